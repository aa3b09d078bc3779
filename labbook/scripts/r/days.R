# The test that decides a comparison, by the days that hold both conditions (docs/statistics.md, "Which test leads").

DAYS_AS_UNITS <- 4 # shared days from which the day is the unit

# The runs of control and treatment of every day that holds both, by day.
runs_by_day <- function(runs, pair) {
  control <- of_conditions(runs, pair[[1]])
  treated <- of_conditions(runs, pair[[2]])
  days <- sort(intersect(control$day, treated$day))
  lapply(setNames(days, days), function(day) list(control[control$day == day, ], treated[treated$day == day, ]))
}

squares_of <- function(runs) sum((runs$value - mean(runs$value))^2)

# What the mean of each day's runs shares with other values: a row a day.
shared_by_day <- function(days, side) {
  errors <- lapply(days, function(day) shared_of(day[[side]]))
  matrix(unlist(errors), length(days), byrow = TRUE, dimnames = list(NULL, names(errors[[1]])))
}

# From four shared days on: the day is the unit, df = days - 1. A paired t with unequal variances is conservative (Bakirov
# and Szekely 2005; Ibragimov and Mueller 2010).
paired_means <- function(runs, pair) {
  days <- runs_by_day(runs, pair)
  k <- length(days)
  control <- vapply(days, function(day) mean(day[[1]]$value), 0)
  treated <- vapply(days, function(day) mean(day[[2]]$value), 0)
  list(
    control = mean(control), treated = mean(treated),
    v_cc = var(control) / k, v_ct = cov(control, treated) / k, v_tt = var(treated) / k, df = k - 1,
    control_shared = colMeans(shared_by_day(days, 1)), treated_shared = colMeans(shared_by_day(days, 2))
  )
}

# The weight n m / (n + m) of each day of n control and m treated runs, as least squares has it.
day_weights <- function(days) {
  weights <- vapply(days, function(day) nrow(day[[1]]) * nrow(day[[2]]) / (nrow(day[[1]]) + nrow(day[[2]])), 0)
  weights / sum(weights)
}

side_within_days <- function(days, side) {
  weights <- day_weights(days)
  n <- vapply(days, function(day) nrow(day[[side]]), 0)
  of_a_run <- sum(vapply(days, function(day) squares_of(day[[side]]), 0)) / sum(n - 1)
  list(
    mean = sum(weights * vapply(days, function(day) mean(day[[side]]$value), 0)),
    variance = of_a_run * sum(weights^2 / n),
    df = sum(n - 1),
    shared = colSums(weights * shared_by_day(days, side))
  )
}

# Fewer shared days: the run is the unit, df the smaller side's, which bound Welch's (Mickey and Brown 1966). With 0 of
# them nothing is claimed; the means are of all runs where no day is shared.
means_within_days <- function(runs, pair) {
  days <- runs_by_day(runs, pair)
  if (length(days) == 0) {
    means <- lapply(pair, function(conditions) mean(of_conditions(runs, conditions)$value))
    return(list(control = means[[1]], treated = means[[2]], df = 0, control_shared = 0, treated_shared = 0))
  }
  control <- side_within_days(days, 1)
  treated <- side_within_days(days, 2)
  list(
    control = control$mean, treated = treated$mean,
    v_cc = control$variance, v_ct = 0, v_tt = treated$variance, df = min(control$df, treated$df),
    control_shared = control$shared, treated_shared = treated$shared
  )
}

compare <- function(runs, pair) {
  if (length(runs_by_day(runs, pair)) >= DAYS_AS_UNITS) paired_means(runs, pair) else means_within_days(runs, pair)
}

# Variance of T - ratio * C by the scatter alone.
own_variance <- function(means, ratio) means$v_tt - 2 * ratio * means$v_ct + ratio^2 * means$v_cc

shared_difference <- function(means, ratio) means$treated_shared - ratio * means$control_shared

# Standard error of T - ratio * C, shared errors with it.
error_of <- function(means, ratio) {
  shared <- shared_difference(means, ratio)
  sqrt(own_variance(means, ratio) + shared_covariance(shared, shared, LEVEL, means$df))
}

difference_of_means <- function(runs) {
  means <- compare(runs, PAIR)
  value <- means$treated - means$control
  if (means$df == 0) return(list(value = value))
  half <- t_quantile(LEVEL, means$df) * error_of(means, 1)
  list(
    value = value, se = sqrt(own_variance(means, 1)), shared_se = shared_se(shared_difference(means, 1)),
    ci_low = value - half, ci_high = value + half, df = means$df, t = t_of(means), p = p_of(means)
  )
}

# Fieller's interval of the saving 100 (1 - T / C) in percent (Fieller 1954); NULL where it is unbounded.
fieller <- function(means) {
  q2 <- t_quantile(LEVEL, means$df)^2
  control <- means$control
  v_cc <- means$v_cc + shared_covariance(means$control_shared, means$control_shared, LEVEL, means$df)
  v_ct <- means$v_ct + shared_covariance(means$control_shared, means$treated_shared, LEVEL, means$df)
  v_tt <- means$v_tt + shared_covariance(means$treated_shared, means$treated_shared, LEVEL, means$df)
  a <- control^2 - q2 * v_cc
  if (a <= 0) return(NULL)
  root <- sqrt(q2 * (control * error_of(means, means$treated / control))^2 - q2^2 * (v_cc * v_tt - v_ct^2))
  middle <- control * (control - means$treated) - q2 * (v_cc - v_ct)
  100 * c(middle - root, middle + root) / a
}

# The saving 100 (1 - T / C) in percent, with Fieller's interval.
saving_of <- function(means) {
  value <- 100 * (means$control - means$treated) / means$control
  if (means$df == 0) return(list(value = value))
  ratio <- means$treated / means$control
  ends <- fieller(means)
  found <- list(
    value = value,
    se = 100 * sqrt(own_variance(means, ratio)) / means$control,
    shared_se = 100 * shared_se(shared_difference(means, ratio)) / means$control,
    df = means$df
  )
  if (is.null(ends)) found else c(found, list(ci_low = ends[1], ci_high = ends[2]))
}

savings <- function(runs) saving_of(compare(runs, PAIR))

t_of <- function(means) (means$treated - means$control) / error_of(means, 1)

# t of the test of no difference, positive for a saving.
t_of_saving <- function(runs) {
  means <- compare(runs, PAIR)
  list(value = -t_of(means), df = means$df)
}

p_of <- function(means) {
  if (ONE_SIDED) pt(-t_of(means), means$df, lower.tail = FALSE) else two_sided_p(t_of(means), means$df)
}

mean_of_control <- function(runs) list(value = compare(runs, PAIR)$control)

# Standard deviation of runs within shared days and conditions, of both sides together.
run_sd <- function(runs) {
  sides <- unlist(runs_by_day(runs, PAIR), recursive = FALSE)
  list(value = sqrt(sum(vapply(sides, squares_of, 0)) / sum(vapply(sides, nrow, 0) - 1)))
}
