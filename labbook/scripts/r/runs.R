# Runs with their values, read from the table beside the script, and printing what was computed.
# A run is a row of a data frame, with its `value`; the matrix `shared` has the signed standard errors that it shares
# with other runs, a column a source, called "fit|term|degrees of freedom". Sources are independent.

read <- function(table) {
  script <- sub("^--file=", "", grep("^--file=", commandArgs(trailingOnly = FALSE), value = TRUE))
  folder <- dirname(gsub("~+~", " ", script, fixed = TRUE)) # R writes a space in its arguments so
  read.csv(file.path(folder, table), stringsAsFactors = FALSE, encoding = "UTF-8",
           colClasses = c(run = "character", day = "character", robot = "character", condition = "character"))
}

of_conditions <- function(runs, conditions) {
  runs[order(match(runs$condition, conditions), na.last = NA), ]
}

# Of several numbers that were computed together the one that is asked for, with the degrees of freedom.
picked <- function(found) c(list(value = found[[PICKED]]), found[intersect("df", names(found))])

show <- function(number) {
  cat(sprintf("%.17g\n", number[["value"]]))
  for (name in setdiff(names(number), "value")) cat(sprintf("%s = %.17g\n", name, number[[name]]))
}

# Errors that values share (docs/statistics.md, "The shared passive-drain error"): they do not average out.

ENOUGH_DF <- 4 # degrees of freedom of a fit from which its error counts as Welch and Satterthwaite have it

t_quantile <- function(level, df) qt((1 - level) / 2, df, lower.tail = FALSE)

two_sided_p <- function(t, df) 2 * pt(abs(t), df, lower.tail = FALSE)

# t and p of the tests against a lower and an upper bound, and the larger p.
one_sided_tests <- function(t_low, t_high, df) {
  p_low <- pt(t_low, df, lower.tail = FALSE)
  p_high <- pt(t_high, df)
  list(t_low = t_low, p_low = p_low, t_high = t_high, p_high = p_high, p = max(p_low, p_high))
}

# Degrees of freedom of a sum of variances, each with its own (Welch 1938, Satterthwaite 1946).
satterthwaite_df <- function(variances, dfs) {
  doubt <- if (sum(variances) > 0) sum((variances / sum(variances))^2 / dfs) else 0
  if (doubt > 0) 1 / doubt else Inf
}

# What the mean of runs shares with other values: the mean of each source.
shared_of <- function(runs) colMeans(runs$shared)

shared_se <- function(shared) sqrt(sum(shared^2))

df_of_sources <- function(shared) as.numeric(sub(".*\\|", "", names(shared)))

# Degrees of freedom of the fits behind an error, Satterthwaite's where they are several.
shared_df <- function(shared) {
  fits <- paste(sub("\\|.*", "", names(shared)), df_of_sources(shared))
  satterthwaite_df(tapply(shared^2, fits, sum), tapply(df_of_sources(shared), fits, max))
}

# Covariance of two values by the errors that they share, as it counts beside a quantile of df: a fit of few degrees of
# freedom has a quantile of its own.
shared_covariance <- function(one, other, level, df) {
  dfs <- df_of_sources(one)
  more <- ifelse(dfs >= ENOUGH_DF, 1, (t_quantile(level, dfs) / t_quantile(level, df))^2)
  sum(more * one * other)
}

# Joules a jump of each run, from the charge that was put back after it and the passive drain of idle runs.

COULOMB_PER_MAH <- 3.6

# Standard deviation of rounding to a step: step / sqrt(12), that of a uniform error.
rounding_sd_mah <- function(resolution_mah) resolution_mah / sqrt(12)

# The least-squares line of charge over duration through idle runs (thesis 5.1.4); the scatter about it is at least that
# of the charger's rounding.
drain_line <- function(idle) {
  duration <- idle$duration_s
  fit <- lm(charge_mah ~ I(duration_s - mean(duration_s)), data = idle)
  residual_sd <- max(sqrt(sum(residuals(fit)^2) / (nrow(idle) - 2)), rounding_sd_mah(max(idle$resolution_mah)))
  list(
    slope_mah_s = coef(fit)[[2]],
    mean_duration_s = mean(duration),
    mean_charge_mah = mean(idle$charge_mah),
    residual_sd_mah = residual_sd,
    slope_se_mah_s = residual_sd / sqrt(sum((duration - mean(duration))^2)),
    r_squared = 1 - sum(residuals(fit)^2) / sum((idle$charge_mah - mean(idle$charge_mah))^2),
    n = nrow(idle)
  )
}

passive_charge_mah <- function(line, duration_s) {
  line$mean_charge_mah + line$slope_mah_s * (duration_s - line$mean_duration_s)
}

# Both independent errors of the line at durations: of its level s / sqrt(n), and of its slope.
line_errors_mah <- function(line, duration_s) {
  cbind(
    level = line$residual_sd_mah / sqrt(line$n) + 0 * duration_s,
    slope = line$slope_se_mah_s * (duration_s - line$mean_duration_s)
  )
}

# The error of rounding, which repeats of a condition share where the charger rounds them alike: a column a reading.
rounding_errors <- function(runs, joules_per_mah) {
  alike <- which(runs$rounded_alike %in% "yes")
  reading <- paste0("rounding|", runs$charge_mah, " mAh, ", runs$condition, "|Inf")
  names <- unique(reading[alike])
  errors <- matrix(0, nrow(runs), length(names), dimnames = list(NULL, names))
  for (i in alike) errors[i, reading[i]] <- joules_per_mah[i] * rounding_sd_mah(runs$resolution_mah[i])
  errors
}

# 3.6 * voltage * (charge - passive charge) / jumps made (thesis 5.1.4), and the errors of the line in it.
joules_of_runs <- function(rows) {
  runs <- rows[rows$kind == "jumps", ]
  joules_per_mah <- COULOMB_PER_MAH * REFERENCE_VOLTAGE_V / runs$jumps_made
  runs$value <- NA
  shared <- rounding_errors(runs, joules_per_mah)
  for (robot in unique(runs$robot)) {
    line <- drain_line(rows[rows$kind == "idle" & rows$robot == robot, ])
    own <- runs$robot == robot
    passive_mah <- passive_charge_mah(line, runs$duration_s[own])
    runs$value[own] <- joules_per_mah[own] * (runs$charge_mah[own] - passive_mah)
    errors <- matrix(0, nrow(runs), 2, dimnames = list(NULL, paste(robot, c("level", "slope"), line$n - 2, sep = "|")))
    errors[own, ] <- -joules_per_mah[own] * line_errors_mah(line, runs$duration_s[own])
    shared <- cbind(shared, errors)
  }
  runs$shared <- shared
  runs
}

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

# Outcomes of which the table has one value a run, as the peak force on a plate.

measured_of_runs <- function(rows) {
  rows$shared <- matrix(0, nrow(rows), 0)
  rows
}

# Values as at the mean position of their day: a drift over the day is taken off.
# Source: docs/statistics.md, "Order within the day".

# Take slope * (position - mean position of the group's day) off every value. The slope is that of least squares of value
# on position, with a constant for every side of a group's day and for every condition. Its error is one that all values
# share.
at_mean_position <- function(runs) {
  placed <- do.call(rbind, lapply(names(GROUPS), function(group) {
    do.call(rbind, lapply(1:2, function(side) {
      own <- of_conditions(runs, GROUPS[[group]][[side]])
      own$group_day <- paste(group, own$day)
      own$cell <- paste(own$group_day, side)
      own
    }))
  }))
  fit <- summary(lm(value ~ position_in_day + factor(cell) + factor(condition), data = placed))
  slope <- fit$coefficients["position_in_day", ]
  away <- placed$position_in_day - ave(placed$position_in_day, placed$group_day)
  placed$value <- placed$value - slope[["Estimate"]] * away
  error <- matrix(-slope[["Std. Error"]] * away, dimnames = list(NULL, paste0("position|slope|", fit$df[2])))
  placed$shared <- cbind(placed$shared, error)
  placed
}

# The numbers of a passive-drain line (thesis 5.1.4): slope, intercept, R squared, and the charge at a duration.

SECONDS_PER_MINUTE <- 60

student <- function(value, se, line) {
  half <- t_quantile(LEVEL, line$n - 2) * se
  list(value = value, se = se, ci_low = value - half, ci_high = value + half, df = line$n - 2)
}

slope <- function(rows) {
  line <- drain_line(rows)
  student(line$slope_mah_s * SECONDS_PER_MINUTE, line$slope_se_mah_s * SECONDS_PER_MINUTE, line)
}

# The charge at a duration, with the error of the line there.
line_at <- function(rows, duration_s) {
  line <- drain_line(rows)
  student(passive_charge_mah(line, duration_s), sqrt(sum(line_errors_mah(line, duration_s)^2)), line)
}

intercept <- function(rows) line_at(rows, 0)

at_run <- function(rows) line_at(rows, RUN_DURATION_S)

r_squared <- function(rows) list(value = drain_line(rows)$r_squared)

# Mean and standard deviation of the runs of a condition.

# Half width of the interval of a mean with its own standard error and shared errors: one quantile over both (Welch,
# Satterthwaite), no less than the scatter alone has; of a fit with few degrees of freedom half widths in quadrature.
half_width <- function(se, df, shared) {
  common <- shared_se(shared)
  alone <- t_quantile(LEVEL, df) * se
  if (se == 0) return(t_quantile(LEVEL, shared_df(shared)) * common)
  if (shared_df(shared) < ENOUGH_DF) return(sqrt(alone^2 + (t_quantile(LEVEL, shared_df(shared)) * common)^2))
  together <- satterthwaite_df(c(se^2, common^2), c(df, shared_df(shared)))
  max(alone, t_quantile(LEVEL, together) * sqrt(se^2 + common^2))
}

condition_mean <- function(runs) {
  n <- nrow(runs)
  shared <- shared_of(runs)
  value <- mean(runs$value)
  if (n < 2) return(list(value = value, shared_se = shared_se(shared), df = 0))
  se <- sd(runs$value) / sqrt(n)
  half <- half_width(se, n - 1, shared)
  list(value = value, se = se, shared_se = shared_se(shared), ci_low = value - half, ci_high = value + half, df = n - 1)
}

condition_sd <- function(runs) list(value = sd(runs$value))

# One-way analysis of variance over the treated conditions of a group (thesis 5.2.1).

analysis_of_variance <- function(runs) {
  found <- oneway.test(value ~ condition, of_conditions(runs, CONDITIONS), var.equal = TRUE)
  list(f = found$statistic[[1]], p = found$p.value)
}

# How far the runs of a battery pack lie from the means of their conditions.

pack_deviation <- function(runs) {
  away <- (runs$value - ave(runs$value, runs$condition))[runs$battery == PACK]
  n <- length(away)
  value <- mean(away)
  if (n < 2) return(list(value = value)) # one run has no scatter
  se <- sd(away) / sqrt(n)
  half <- t_quantile(LEVEL, n - 1) * se
  list(value = value, se = se, ci_low = value - half, ci_high = value + half)
}

# What the uncertainty of joules a jump is made of (thesis 5.1.4): of one run, and of the mean of a condition's runs. The
# step of the charger is in the scatter where it differs from run to run; where repeats are rounded alike, it is added.

joules_of_mah <- function(runs) mean(COULOMB_PER_MAH * REFERENCE_VOLTAGE_V / runs$jumps_made)

parted <- function(runs, rounding) runs$shared[, startsWith(colnames(runs$shared), "rounding|") == rounding, drop = FALSE]

of_one_step <- function(runs) joules_of_mah(runs) * rounding_sd_mah(max(runs$resolution_mah))

# What rounding gives the mean where repeats are rounded alike; 0 where they are not.
rounded_alike <- function(runs) shared_se(colMeans(parted(runs, TRUE)))

# What each source gives one run and the mean, all in quadrature, and what 1 mAh is worth.
budget <- function(runs) {
  n <- nrow(runs)
  alike <- rounded_alike(runs)
  step <- of_one_step(runs)
  scatter <- sd(runs$value)
  drains <- parted(runs, FALSE)
  drain <- sqrt(mean(rowSums(drains^2)))
  drain_of_mean <- shared_se(colMeans(drains)) # all runs share it
  list(
    "scatter between runs" = scatter, "drain fit" = drain, "charger resolution" = step, "reference voltage" = 0,
    "in all" = sqrt(scatter^2 + drain^2 + (if (alike > 0) step else 0)^2),
    "scatter between runs, mean" = scatter / sqrt(n), "drain fit, mean" = drain_of_mean,
    "charger resolution, mean" = if (alike > 0) alike else step / sqrt(n), "reference voltage, mean" = 0,
    "in all, mean" = sqrt(scatter^2 / n + drain_of_mean^2 + alike^2), "1 mAh" = joules_of_mah(runs)
  )
}
