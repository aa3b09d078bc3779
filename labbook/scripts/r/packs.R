# How far the runs of a battery pack lie from the means of their conditions.

pack_deviation <- function(runs) {
  away <- (runs$value - ave(runs$value, runs$condition))[runs$battery == PACK]
  n <- length(away)
  value <- mean(away)
  if (n < 2) return(list(value = value)) # one run has no scatter
  se <- sd(away) / sqrt(n)
  half <- t_quantile(LEVEL, n - 1) * se
  list(value = value, se = se, ci_low = value - half, ci_high = value + half)
}
