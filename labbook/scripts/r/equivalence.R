# Two one-sided tests that a difference lies within bounds (TOST, Schuirmann 1987), by the contrast that decides.

# t of T - (1 + bound / 100) C, or of T - C - bound where the bound is no percentage.
t_at <- function(means, bound) {
  if (is.infinite(bound)) return(-bound)
  ratio <- if (IN_PERCENT) 1 + bound / 100 else 1
  shift <- if (IN_PERCENT) 0 else bound
  (means$treated - ratio * means$control - shift) / error_of(means, ratio)
}

# The change with its interval of level 1 - 2 alpha, Fieller's in percent, else Student's, and the tests against both bounds.
equivalence <- function(runs) {
  means <- compare(runs, PAIR)
  change <- means$treated - means$control
  if (IN_PERCENT) {
    saved <- fieller(means)
    change <- 100 * change / means$control
    ends <- if (is.null(saved)) NULL else -rev(saved)
  } else {
    ends <- change + c(-1, 1) * t_quantile(LEVEL, means$df) * error_of(means, 1)
  }
  c(
    list(value = change), if (!is.null(ends)) list(ci_low = ends[1], ci_high = ends[2]), list(df = means$df),
    one_sided_tests(t_at(means, LOW), t_at(means, HIGH), means$df)
  )
}
