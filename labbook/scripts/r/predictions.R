# What the simulator gives for the runs as they were made, beside what was measured of them. Simulated values stand in the
# table, with the parameters as they are, and with each assumed one lowered and raised. The error ratio is E_n of ISO 13528.

COVERAGE_FACTOR <- 2 # standard uncertainties of a prediction that its expanded uncertainty has

fields_of <- function(cell) strsplit(as.character(cell), ";", fixed = TRUE)[[1]]

# What was simulated for a run with each assumed parameter otherwise; NaN where the jump has no apex.
varied_in <- function(run) {
  if (run$varied %in% c("", NA)) return(list())
  split(as.numeric(fields_of(run$simulated_varied)), factor(fields_of(run$varied), unique(fields_of(run$varied))))
}

# The mean of the simulated values over runs, with a parameter lowered (place 1) or raised (2).
simulated_mean <- function(runs, parameter = "", place = 1) {
  mean(vapply(seq_len(nrow(runs)), function(i) {
    varied <- varied_in(runs[i, ])[[parameter]]
    if (is.null(varied)) as.numeric(runs$simulated[i]) else varied[place]
  }, 0))
}

relative_error <- function(sides) max(vapply(sides, function(side) max(side$simulated_error), 0))

# The parts of the error of what follows from means: a parameter is another in all of them at once.
errors_by <- function(sides, of_means, accuracy) {
  means <- function(...) of_means(vapply(sides, function(side) simulated_mean(side, ...), 0))
  value <- means()
  parts <- list(accuracy = accuracy)
  for (side in sides) for (i in seq_len(nrow(side))) {
    varied <- varied_in(side[i, ])
    for (name in setdiff(names(varied), names(parts))) {
      parts[[name]] <- max(abs(vapply(seq_along(varied[[name]]), function(place) means(name, place), 0) - value))
    }
  }
  parts
}

# A prediction with its standard uncertainty; without one where a varied jump has no apex.
with_error <- function(value, parts) {
  se <- sqrt(sum(unlist(parts)^2))
  if (is.nan(se)) list(value = value) else list(value = value, se = se)
}

saving_in_percent <- function(means) 100 * (1 - means[2] / means[1])

sides_of_pair <- function(runs) lapply(PAIR, function(conditions) of_conditions(runs, conditions))

errors_of_mean <- function(runs) {
  errors_by(list(runs), function(means) means[1], relative_error(list(runs)) * abs(simulated_mean(runs)))
}

# The simulator's error is in both means of a saving.
errors_of_saving <- function(runs) {
  sides <- sides_of_pair(runs)
  saved <- saving_in_percent(vapply(sides, simulated_mean, 0))
  errors_by(sides, saving_in_percent, sqrt(2) * relative_error(sides) * abs(100 - saved))
}

predicted_mean <- function(runs) with_error(simulated_mean(runs), errors_of_mean(runs))

predicted_saving <- function(runs) {
  with_error(saving_in_percent(vapply(sides_of_pair(runs), simulated_mean, 0)), errors_of_saving(runs))
}

error_of_mean_by <- function(runs) list(value = errors_of_mean(runs)[[ERROR_BY]])

error_of_saving_by <- function(runs) list(value = errors_of_saving(runs)[[ERROR_BY]])

away_from <- function(measured, predicted) list(value = predicted$value - measured$value)

# E_n: the half interval on the side of the prediction, at 95 %, beside two standard uncertainties.
error_ratio <- function(measured, predicted, level) {
  difference <- predicted$value - measured$value
  half <- measured[[if (difference > 0) "ci_high" else "ci_low"]] - measured$value
  if (level != 0.95) half <- half * t_quantile(0.95, measured$df) / t_quantile(level, measured$df)
  list(value = difference / sqrt(half^2 + (COVERAGE_FACTOR * predicted$se)^2))
}

mean_predicted_less_measured <- function(runs) away_from(condition_mean(runs), predicted_mean(runs))

error_ratio_of_mean <- function(runs) error_ratio(condition_mean(runs), predicted_mean(runs), LEVEL)

saving_predicted_less_measured <- function(runs) away_from(saving_of(compare(runs, PAIR)), predicted_saving(runs))

error_ratio_of_saving <- function(runs) error_ratio(saving_of(compare(runs, PAIR)), predicted_saving(runs), LEVEL)

# What the simulator gives for a hypothesis: the change of a mean in percent of another, or of a saving in points.

change_in_percent <- function(means) {
  changes <- 100 * (means[c(FALSE, TRUE)] / means[c(TRUE, FALSE)] - 1)
  if (length(changes) == 1) changes else changes[1] - changes[2]
}

# The simulated change with its standard uncertainty; the simulator errs in each mean by itself.
simulated_change <- function(runs) {
  sides <- lapply(COMPARED, function(conditions) of_conditions(runs, conditions))
  accuracy <- sqrt(length(sides)) * relative_error(sides) * 100
  value <- change_in_percent(vapply(sides, simulated_mean, 0))
  with_error(value, errors_by(sides, change_in_percent, accuracy))
}

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
