# The thesis's own tests (5.2.1): F of two variances, and Student's or Welch's t as F decides, over runs or jumps.

control_values <- function(runs) of_conditions(runs, PAIR[[1]])$value

treated_values <- function(runs) of_conditions(runs, PAIR[[2]])$value

f_of <- function(runs) var(treated_values(runs)) / var(control_values(runs))

# Twice the smaller tail of F, as var.test, which loses the digits of a small p.
f_p_of <- function(runs) {
  df <- c(length(treated_values(runs)), length(control_values(runs))) - 1
  2 * min(pf(f_of(runs), df[1], df[2]), pf(f_of(runs), df[1], df[2], lower.tail = FALSE))
}

means_tested <- function(runs) {
  equal <- f_p_of(runs) >= ALPHA
  t.test(treated_values(runs), control_values(runs), var.equal = equal, conf.level = 1 - ALPHA)
}

f_of_variances <- function(runs) list(value = f_of(runs))

p_of_variances <- function(runs) list(value = f_p_of(runs))

difference_of_samples <- function(runs) {
  value <- mean(treated_values(runs)) - mean(control_values(runs))
  if (min(length(treated_values(runs)), length(control_values(runs))) < 2) return(list(value = value))
  found <- means_tested(runs)
  list(value = value, ci_low = found$conf.int[1], ci_high = found$conf.int[2], df = found$parameter[[1]])
}

t_of_samples <- function(runs) {
  found <- means_tested(runs)
  list(value = found$statistic[[1]], df = found$parameter[[1]])
}

p_of_samples <- function(runs) {
  found <- means_tested(runs)
  list(value = found$p.value, df = found$parameter[[1]])
}
