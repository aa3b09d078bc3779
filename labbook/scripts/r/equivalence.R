# Two one-sided tests that a difference lies within bounds (TOST, Schuirmann 1987), by the contrast that decides.

# t of T - (1 + bound / 100) C, or of T - C - bound where the bound is no percentage.
t_at <- function(means, bound) {
  ratio <- if (IN_PERCENT) 1 + bound / 100 else 1
  shift <- if (IN_PERCENT) 0 else bound
  (means$treated - ratio * means$control - shift) / error_of(means, ratio)
}

# The change with its interval of level 1 - 2 alpha: Fieller's in percent, else Student's.
estimate <- function(runs) {
  means <- compare(runs, PAIR)
  change <- means$treated - means$control
  if (IN_PERCENT) {
    saved <- fieller(means)
    change <- 100 * change / means$control
    if (is.null(saved)) return(list(value = change))
    ends <- -rev(saved)
  } else {
    ends <- change + c(-1, 1) * t_quantile(LEVEL, means$df) * error_of(means, 1)
  }
  list(value = change, ci_low = ends[1], ci_high = ends[2])
}

t_low <- function(runs) {
  means <- compare(runs, PAIR)
  list(value = t_at(means, LOW), df = means$df)
}

p_low <- function(runs) {
  means <- compare(runs, PAIR)
  list(value = pt(t_at(means, LOW), means$df, lower.tail = FALSE), df = means$df)
}

t_high <- function(runs) {
  means <- compare(runs, PAIR)
  list(value = t_at(means, HIGH), df = means$df)
}

p_high <- function(runs) {
  means <- compare(runs, PAIR)
  list(value = pt(t_at(means, HIGH), means$df), df = means$df)
}

# The larger p of both tests, or that of the one bound there is.
p_of_both <- function(runs) {
  list(value = max(c(if (is.finite(LOW)) p_low(runs)$value, if (is.finite(HIGH)) p_high(runs)$value)))
}
