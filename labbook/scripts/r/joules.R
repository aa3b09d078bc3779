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
