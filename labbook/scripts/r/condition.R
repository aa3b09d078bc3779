# Mean and standard deviation of the runs of a condition.

# Half width of the interval of a mean with its own standard error and shared errors: one quantile over both (Welch,
# Satterthwaite), no less than the scatter alone has; of a fit with few degrees of freedom half widths in quadrature.
half_width <- function(se, df, shared) {
  common <- shared_se(shared)
  alone <- t_quantile(LEVEL, df) * se
  if (se == 0) return(t_quantile(LEVEL, shared_df(shared)) * common)
  if (shared_df(shared) < ENOUGH_DF) return(sqrt(alone^2 + (t_quantile(LEVEL, shared_df(shared)) * common)^2))
  together <- satterthwaite_df(c(se^2, common^2), c(df, shared_df(shared)))
  max(alone, t_quantile(LEVEL, together) * sqrt(se^2 + common^2))
}

condition_mean <- function(runs) {
  n <- nrow(runs)
  shared <- shared_of(runs)
  value <- mean(runs$value)
  if (n < 2) return(list(value = value, shared_se = shared_se(shared), df = 0))
  se <- sd(runs$value) / sqrt(n)
  half <- half_width(se, n - 1, shared)
  list(value = value, se = se, shared_se = shared_se(shared), ci_low = value - half, ci_high = value + half, df = n - 1)
}

condition_sd <- function(runs) list(value = sd(runs$value))
