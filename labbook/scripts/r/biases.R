# How far predictions lie from what was measured: the mean over days of each day's mean of predicted less measured. The
# scatter between days is its error, with what runs share by a calibration or a drain line, and predictions by the inputs
# that they assume, in quadrature (Welch, Satterthwaite; JCGM 100:2008, G.4).

predictions_of <- function(runs) {
  conditions <- unique(runs$condition)
  lapply(setNames(conditions, conditions), function(condition) predicted_mean(of_conditions(runs, condition)))
}

by_day_of <- function(runs) {
  predicted <- vapply(predictions_of(runs), function(each) each$value, 0)[runs$condition]
  list(measured = tapply(runs$value, runs$day, mean), predicted = tapply(predicted, runs$day, mean))
}

# The bias with its interval and the p of none; on one day, or where nothing scatters, it has no interval.
bias_of <- function(runs, assumed) {
  means <- by_day_of(runs)
  away <- as.vector(means$predicted - means$measured)
  days <- length(away)
  value <- mean(away)
  if (days < 2) return(list(value = value))
  shared <- shared_of(runs)
  variances <- c(var(away) / days, shared_se(shared)^2)
  dfs <- c(days - 1, shared_df(shared))
  if (assumed) {
    predicted <- predictions_of(runs)
    of_runs <- vapply(runs$condition, function(condition) predicted[[condition]]$se, 0)
    variances <- c(variances, mean(of_runs)^2)
    dfs <- c(dfs, Inf)
  }
  se <- sqrt(sum(variances))
  if (se == 0) return(list(value = value))
  df <- satterthwaite_df(variances, dfs)
  half <- t_quantile(LEVEL, df) * se
  list(value = value, se = se, ci_low = value - half, ci_high = value + half, df = df, p = two_sided_p(value / se, df))
}

bias <- function(runs) bias_of(runs, TRUE)

bias_of_measured <- function(runs) bias_of(runs, FALSE)

measured_over_days <- function(runs) list(value = mean(by_day_of(runs)$measured))

predicted_over_days <- function(runs) list(value = mean(by_day_of(runs)$predicted))

# The p of no bias in any group: Bonferroni's.
joint_p <- function(runs) {
  ps <- unlist(lapply(JUDGED, function(conditions) bias_of(of_conditions(runs, conditions), TRUE)$p))
  list(value = min(p.adjust(ps, "bonferroni")))
}

# Kendall's tau of the measured and the predicted order of groups; a tie counts for nothing.
tau_of_groups <- function(runs) {
  groups <- lapply(JUDGED, function(conditions) by_day_of(of_conditions(runs, conditions)))
  order_of <- function(name) {
    means <- vapply(groups, function(group) mean(group[[name]]), 0)
    sign(outer(means, means, "-"))
  }
  n <- length(groups)
  list(value = sum(order_of("measured") * order_of("predicted")) / (n * (n - 1)))
}

# The mean difference and the limits of agreement over conditions, each with its standard error (Bland and Altman 1986).
limits_of <- function(runs) {
  away <- vapply(unique(runs$condition), function(condition) {
    own <- of_conditions(runs, condition)
    predicted_mean(own)$value - condition_mean(own)$value
  }, 0)
  n <- length(away)
  z <- t_quantile(LEVEL, Inf)
  of_limit <- sd(away) * sqrt(1 / n + z^2 / (2 * (n - 1)))
  list(
    mean = c(mean(away), sd(away) / sqrt(n)),
    low = c(mean(away) - z * sd(away), of_limit), high = c(mean(away) + z * sd(away), of_limit)
  )
}

with_ends <- function(runs, name) {
  found <- limits_of(runs)[[name]]
  df <- length(unique(runs$condition)) - 1
  half <- t_quantile(LEVEL, df) * found[2]
  list(value = found[1], se = found[2], ci_low = found[1] - half, ci_high = found[1] + half, df = df)
}

mean_difference <- function(runs) with_ends(runs, "mean")

lower_limit <- function(runs) with_ends(runs, "low")

upper_limit <- function(runs) with_ends(runs, "high")
