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
