# The thesis's own tests (5.2.1): F of two variances, and Student's or Welch's t as F decides, over runs or jumps.

# The treatment less the control with its interval, t and p: Student's where F rejects nothing, else Welch's. The p of F is
# twice the smaller tail, as var.test, which loses the digits of a small p.
thesis_route <- function(runs) {
  control <- of_conditions(runs, PAIR[[1]])$value
  treated <- of_conditions(runs, PAIR[[2]])$value
  value <- mean(treated) - mean(control)
  if (min(length(treated), length(control)) < 2) return(list(value = value))
  f <- var(treated) / var(control)
  df <- c(length(treated), length(control)) - 1
  f_p <- min(1, 2 * min(pf(f, df[1], df[2]), pf(f, df[1], df[2], lower.tail = FALSE)))
  found <- t.test(treated, control, var.equal = f_p >= ALPHA, conf.level = 1 - ALPHA)
  list(
    value = value, ci_low = found$conf.int[1], ci_high = found$conf.int[2], df = found$parameter[[1]],
    t = found$statistic[[1]], p = found$p.value, f = f, f_p = f_p
  )
}
