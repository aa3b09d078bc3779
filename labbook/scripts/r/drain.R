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
