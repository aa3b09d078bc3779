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
