# One effect for a campaign: the mean of its groups' savings, each counted once (docs/statistics.md).

# The saving of a group as a share of its control, S = 1 - T / C, and its errors, with the sign of T; of four days or more
# also what each day departs by, over sqrt(k (k - 1)).
saving_of_group <- function(runs, pair) {
  means <- compare(runs, pair)
  days <- runs_by_day(runs, pair)
  ratio <- means$treated / means$control
  k <- length(days)
  by_day <- vapply(days, function(day) {
    departs <- (mean(day[[2]]$value) - means$treated) - ratio * (mean(day[[1]]$value) - means$control)
    departs / means$control / sqrt(k * (k - 1))
  }, 0)
  list(
    saved = 1 - ratio, variance = own_variance(means, ratio) / means$control^2, df = means$df,
    by_day = if (k >= DAYS_AS_UNITS) by_day else numeric(0),
    shared = shared_difference(means, ratio) / means$control
  )
}

savings_of_groups <- function(runs) lapply(CLAIMED, function(pair) saving_of_group(runs, pair))

of_each <- function(savings, name) vapply(savings, function(saving) saving[[name]], 0)

# What each day adds to the error of each group's saving: a row a group, a column a day.
departures <- function(savings) {
  days <- sort(unique(unlist(lapply(savings, function(saving) names(saving$by_day)))))
  errors <- matrix(0, length(savings), length(days), dimnames = list(NULL, days))
  for (i in seq_along(savings)) errors[i, names(savings[[i]]$by_day)] <- savings[[i]]$by_day
  errors
}

is_within <- function(savings) vapply(savings, function(saving) length(saving$by_day) == 0, NA)

# The mean saving: what a day does to all groups is added up before it is squared.
over_groups <- function(savings) {
  n <- length(savings)
  errors <- departures(savings)
  variance <- sum((colSums(errors) / n)^2) + sum(of_each(savings, "variance")[is_within(savings)]) / n^2
  df <- satterthwaite_df(of_each(savings, "variance"), of_each(savings, "df"))
  if (ncol(errors) > 0) df <- min(df, ncol(errors) - 1)
  shared <- Reduce(`+`, lapply(savings, function(saving) saving$shared)) / n
  list(
    saved = mean(of_each(savings, "saved")),
    error = sqrt(variance + shared_covariance(shared, shared, LEVEL, df)),
    own_se = sqrt(variance), shared_se = shared_se(shared), df = df
  )
}

overall_savings <- function(runs) {
  found <- over_groups(savings_of_groups(runs))
  value <- 100 * found$saved
  half <- 100 * t_quantile(LEVEL, found$df) * found$error
  t <- found$saved / found$error
  list(
    value = value, se = 100 * found$own_se, shared_se = 100 * found$shared_se,
    ci_low = value - half, ci_high = value + half, df = found$df, t = t,
    p = if (ONE_SIDED_OVERALL) pt(t, found$df, lower.tail = FALSE) else two_sided_p(t, found$df)
  )
}

spread <- function(runs) list(value = sd(100 * of_each(savings_of_groups(runs), "saved")))

# The p of equal savings: F = S'MS / tr(MV) with Box's degrees of freedom tr(MV)^2 / tr(MVMV) (Box 1954). V is the
# covariance of the savings S, and M takes off their mean.
heterogeneity_p <- function(runs) {
  savings <- savings_of_groups(runs)
  n <- length(savings)
  errors <- departures(savings)
  df <- satterthwaite_df(of_each(savings, "variance"), of_each(savings, "df"))
  common <- outer(seq_len(n), seq_len(n), Vectorize(function(i, j) {
    shared_covariance(savings[[i]]$shared, savings[[j]]$shared, LEVEL, df)
  }))
  v <- errors %*% t(errors) + diag(ifelse(is_within(savings), of_each(savings, "variance"), 0), n) + common
  m <- diag(n) - 1 / n
  s <- of_each(savings, "saved")
  trace <- sum(diag(m %*% v))
  box <- trace^2 / sum(diag(m %*% v %*% m %*% v))
  df_within <- if (ncol(errors) > 0) min(df, box * (ncol(errors) - 1)) else df
  list(value = pf(drop(s %*% m %*% s) / trace, box, df_within, lower.tail = FALSE))
}

# The mean change in percent of each control, with its interval of level 1 - 2 alpha, and both tests.
overall_equivalence <- function(runs) {
  found <- over_groups(savings_of_groups(runs))
  change <- -100 * found$saved
  error <- 100 * found$error
  half <- t_quantile(LEVEL, found$df) * error
  c(
    list(value = change, ci_low = change - half, ci_high = change + half, df = found$df),
    one_sided_tests((change - LOWEST_CHANGE) / error, (change - HIGHEST_CHANGE) / error, found$df)
  )
}
