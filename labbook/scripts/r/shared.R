# Errors that values share (docs/statistics.md, "The shared passive-drain error"): they do not average out.

ENOUGH_DF <- 4 # degrees of freedom of a fit from which its error counts as Welch and Satterthwaite have it

t_quantile <- function(level, df) qt((1 - level) / 2, df, lower.tail = FALSE)

two_sided_p <- function(t, df) 2 * pt(abs(t), df, lower.tail = FALSE)

# t and p of the tests against a lower and an upper bound, and the larger p.
one_sided_tests <- function(t_low, t_high, df) {
  p_low <- pt(t_low, df, lower.tail = FALSE)
  p_high <- pt(t_high, df)
  list(t_low = t_low, p_low = p_low, t_high = t_high, p_high = p_high, p = max(p_low, p_high))
}

# Degrees of freedom of a sum of variances, each with its own (Welch 1938, Satterthwaite 1946).
satterthwaite_df <- function(variances, dfs) {
  doubt <- if (sum(variances) > 0) sum((variances / sum(variances))^2 / dfs) else 0
  if (doubt > 0) 1 / doubt else Inf
}

# What the mean of runs shares with other values: the mean of each source.
shared_of <- function(runs) colMeans(runs$shared)

shared_se <- function(shared) sqrt(sum(shared^2))

df_of_sources <- function(shared) as.numeric(sub(".*\\|", "", names(shared)))

# Degrees of freedom of the fits behind an error, Satterthwaite's where they are several.
shared_df <- function(shared) {
  fits <- paste(sub("\\|.*", "", names(shared)), df_of_sources(shared))
  satterthwaite_df(tapply(shared^2, fits, sum), tapply(df_of_sources(shared), fits, max))
}

# Covariance of two values by the errors that they share, as it counts beside a quantile of df: a fit of few degrees of
# freedom has a quantile of its own.
shared_covariance <- function(one, other, level, df) {
  dfs <- df_of_sources(one)
  more <- ifelse(dfs >= ENOUGH_DF, 1, (t_quantile(level, dfs) / t_quantile(level, df))^2)
  sum(more * one * other)
}
