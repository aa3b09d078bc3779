# What the uncertainty of joules a jump is made of (thesis 5.1.4): of one run, and of the mean of a condition's runs. The
# step of the charger is in the scatter where it differs from run to run; where repeats are rounded alike, it is added.

joules_of_mah <- function(runs) mean(COULOMB_PER_MAH * REFERENCE_VOLTAGE_V / runs$jumps_made)

parted <- function(runs, rounding) runs$shared[, startsWith(colnames(runs$shared), "rounding|") == rounding, drop = FALSE]

of_one_step <- function(runs) joules_of_mah(runs) * rounding_sd_mah(max(runs$resolution_mah))

# What rounding gives the mean where repeats are rounded alike; 0 where they are not.
rounded_alike <- function(runs) shared_se(colMeans(parted(runs, TRUE)))

run_by_scatter <- function(runs) list(value = sd(runs$value))

mean_by_scatter <- function(runs) list(value = sd(runs$value) / sqrt(nrow(runs)))

run_by_drain <- function(runs) list(value = sqrt(mean(rowSums(parted(runs, FALSE)^2))))

mean_by_drain <- function(runs) list(value = shared_se(colMeans(parted(runs, FALSE))))

run_by_step <- function(runs) list(value = of_one_step(runs))

mean_by_step <- function(runs) {
  list(value = if (rounded_alike(runs) > 0) rounded_alike(runs) else of_one_step(runs) / sqrt(nrow(runs)))
}

of_voltage <- function(runs) list(value = 0 * nrow(runs))

run_in_all <- function(runs) {
  step <- if (rounded_alike(runs) > 0) of_one_step(runs) else 0
  list(value = sqrt(var(runs$value) + run_by_drain(runs)$value^2 + step^2))
}

mean_in_all <- function(runs) {
  list(value = sqrt(var(runs$value) / nrow(runs) + mean_by_drain(runs)$value^2 + rounded_alike(runs)^2))
}

one_mah <- function(runs) list(value = joules_of_mah(runs))
