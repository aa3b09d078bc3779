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
