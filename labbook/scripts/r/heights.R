# The apex height of each run: the mean of its jumps that count, and what it takes from a calibration.

# What each independent error of a calibrated height makes of the height of each jump: a column a source. The calibration
# errs by slope * reading + intercept, the reading being (sign * height - zero) / scale.
calibration_errors_m <- function(rows) {
  errors <- matrix(0, nrow(rows), 0)
  for (calibration in setdiff(unique(as.character(rows$calibration)), c("", NA))) {
    own <- which(rows$calibration == calibration)
    jumps <- rows[own, ]
    reading <- (jumps$height_sign * jumps$apex_height_m - jumps$height_zero) / jumps$height_scale
    slopes <- as.numeric(strsplit(as.character(jumps$error_slopes[1]), " ")[[1]])
    intercepts <- as.numeric(strsplit(as.character(jumps$error_intercepts[1]), " ")[[1]])
    for (i in seq_along(slopes)) {
      error <- numeric(nrow(rows))
      per_value <- jumps$height_sign * jumps$height_scale / jumps$calibration_scale
      error[own] <- per_value * (slopes[i] * reading + intercepts[i])
      errors <- cbind(errors, error)
      colnames(errors)[ncol(errors)] <- paste(calibration, i, jumps$calibration_df[1], sep = "|")
    }
  }
  errors
}

# The mean apex height of every run, and the mean of each calibration error over its jumps.
heights_of_runs <- function(rows) {
  runs <- rows[!duplicated(rows$run), ]
  jumps <- split(seq_len(nrow(rows)), factor(rows$run, levels = runs$run))
  errors <- calibration_errors_m(rows)
  runs$value <- vapply(jumps, function(own) mean(rows$apex_height_m[own]), 0)
  shared <- vapply(jumps, function(own) colMeans(errors[own, , drop = FALSE]), numeric(ncol(errors)))
  runs$shared <- matrix(t(shared), nrow(runs), ncol(errors), dimnames = list(NULL, colnames(errors)))
  runs
}

# Every jump with its own height, as if it were a run (the thesis's tests of the bed, 5.2).
heights_of_jumps <- function(rows) {
  rows$value <- rows$apex_height_m
  rows
}
