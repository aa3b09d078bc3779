# The test that decides a comparison, by the days that hold both conditions (docs/statistics.md, "Which test leads").

DAYS_AS_UNITS <- 4 # shared days from which the day is the unit

# The runs of control and treatment of every day that holds both, by day.
runs_by_day <- function(runs, pair) {
  control <- of_conditions(runs, pair[[1]])
  treated <- of_conditions(runs, pair[[2]])
  days <- sort(intersect(control$day, treated$day))
  lapply(setNames(days, days), function(day) list(control[control$day == day, ], treated[treated$day == day, ]))
}

squares_of <- function(runs) sum((runs$value - mean(runs$value))^2)

# What the mean of each day's runs shares with other values: a row a day.
shared_by_day <- function(days, side) {
  errors <- lapply(days, function(day) shared_of(day[[side]]))
  matrix(unlist(errors), length(days), byrow = TRUE, dimnames = list(NULL, names(errors[[1]])))
}

# From four shared days on: the day is the unit, df = days - 1. A paired t with unequal variances is conservative (Bakirov
# and Szekely 2005; Ibragimov and Mueller 2010).
paired_means <- function(runs, pair) {
  days <- runs_by_day(runs, pair)
  k <- length(days)
  control <- vapply(days, function(day) mean(day[[1]]$value), 0)
  treated <- vapply(days, function(day) mean(day[[2]]$value), 0)
  list(
    control = mean(control), treated = mean(treated),
    v_cc = var(control) / k, v_ct = cov(control, treated) / k, v_tt = var(treated) / k, df = k - 1,
    control_shared = colMeans(shared_by_day(days, 1)), treated_shared = colMeans(shared_by_day(days, 2))
  )
}

# The weight n m / (n + m) of each day of n control and m treated runs, as least squares has it.
day_weights <- function(days) {
  weights <- vapply(days, function(day) nrow(day[[1]]) * nrow(day[[2]]) / (nrow(day[[1]]) + nrow(day[[2]])), 0)
  weights / sum(weights)
}

side_within_days <- function(days, side) {
  weights <- day_weights(days)
  n <- vapply(days, function(day) nrow(day[[side]]), 0)
  of_a_run <- sum(vapply(days, function(day) squares_of(day[[side]]), 0)) / sum(n - 1)
  list(
    mean = sum(weights * vapply(days, function(day) mean(day[[side]]$value), 0)),
    variance = of_a_run * sum(weights^2 / n),
    df = sum(n - 1),
    shared = colSums(weights * shared_by_day(days, side))
  )
}

# Fewer shared days: the run is the unit, df the smaller side's, which bound Welch's (Mickey and Brown 1966). With 0 of
# them nothing is claimed; the means are of all runs where no day is shared.
means_within_days <- function(runs, pair) {
  days <- runs_by_day(runs, pair)
  if (length(days) == 0) {
    means <- lapply(pair, function(conditions) mean(of_conditions(runs, conditions)$value))
    return(list(control = means[[1]], treated = means[[2]], df = 0, control_shared = 0, treated_shared = 0))
  }
  control <- side_within_days(days, 1)
  treated <- side_within_days(days, 2)
  list(
    control = control$mean, treated = treated$mean,
    v_cc = control$variance, v_ct = 0, v_tt = treated$variance, df = min(control$df, treated$df),
    control_shared = control$shared, treated_shared = treated$shared
  )
}

compare <- function(runs, pair) {
  if (length(runs_by_day(runs, pair)) >= DAYS_AS_UNITS) paired_means(runs, pair) else means_within_days(runs, pair)
}

# Variance of T - ratio * C by the scatter alone.
own_variance <- function(means, ratio) means$v_tt - 2 * ratio * means$v_ct + ratio^2 * means$v_cc

shared_difference <- function(means, ratio) means$treated_shared - ratio * means$control_shared

# Standard error of T - ratio * C, shared errors with it.
error_of <- function(means, ratio) {
  shared <- shared_difference(means, ratio)
  sqrt(own_variance(means, ratio) + shared_covariance(shared, shared, LEVEL, means$df))
}

difference_of_means <- function(runs) {
  means <- compare(runs, PAIR)
  value <- means$treated - means$control
  if (means$df == 0) return(list(value = value))
  half <- t_quantile(LEVEL, means$df) * error_of(means, 1)
  list(
    value = value, se = sqrt(own_variance(means, 1)), shared_se = shared_se(shared_difference(means, 1)),
    ci_low = value - half, ci_high = value + half, df = means$df, t = t_of(means), p = p_of(means)
  )
}

# Fieller's interval of the saving 100 (1 - T / C) in percent (Fieller 1954); NULL where it is unbounded.
fieller <- function(means) {
  q2 <- t_quantile(LEVEL, means$df)^2
  control <- means$control
  v_cc <- means$v_cc + shared_covariance(means$control_shared, means$control_shared, LEVEL, means$df)
  v_ct <- means$v_ct + shared_covariance(means$control_shared, means$treated_shared, LEVEL, means$df)
  v_tt <- means$v_tt + shared_covariance(means$treated_shared, means$treated_shared, LEVEL, means$df)
  a <- control^2 - q2 * v_cc
  if (a <= 0) return(NULL)
  root <- sqrt(q2 * (control * error_of(means, means$treated / control))^2 - q2^2 * (v_cc * v_tt - v_ct^2))
  middle <- control * (control - means$treated) - q2 * (v_cc - v_ct)
  100 * c(middle - root, middle + root) / a
}

# The saving 100 (1 - T / C) in percent, with Fieller's interval.
saving_of <- function(means) {
  value <- 100 * (means$control - means$treated) / means$control
  if (means$df == 0) return(list(value = value))
  ratio <- means$treated / means$control
  ends <- fieller(means)
  found <- list(
    value = value,
    se = 100 * sqrt(own_variance(means, ratio)) / means$control,
    shared_se = 100 * shared_se(shared_difference(means, ratio)) / means$control,
    df = means$df
  )
  if (is.null(ends)) found else c(found, list(ci_low = ends[1], ci_high = ends[2]))
}

savings <- function(runs) saving_of(compare(runs, PAIR))

t_of <- function(means) (means$treated - means$control) / error_of(means, 1)

# t of the test of no difference, positive for a saving.
t_of_saving <- function(runs) {
  means <- compare(runs, PAIR)
  list(value = -t_of(means), df = means$df)
}

p_of <- function(means) {
  if (ONE_SIDED) pt(-t_of(means), means$df, lower.tail = FALSE) else two_sided_p(t_of(means), means$df)
}

mean_of_control <- function(runs) list(value = compare(runs, PAIR)$control)

# Standard deviation of runs within shared days and conditions, of both sides together.
run_sd <- function(runs) {
  sides <- unlist(runs_by_day(runs, PAIR), recursive = FALSE)
  list(value = sqrt(sum(vapply(sides, squares_of, 0)) / sum(vapply(sides, nrow, 0) - 1)))
}

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

# Weighted sums of effects on shared days: differences of levels, interactions, trends.
# Source: docs/statistics.md, "What the saving depends on"; savings by the delta method.
# An effect is list(weight, list(conditions of a reference, conditions of what is compared with it)).

# Whether the days of each effect are its units: four or more, and no condition is in an effect of fewer.
days_are_units <- function(runs, effects) {
  by_days <- vapply(effects, function(effect) length(runs_by_day(runs, effect[[2]])) >= DAYS_AS_UNITS, NA)
  sides <- lapply(effects, function(effect) vapply(effect[[2]], paste, "", collapse = "; "))
  mixed <- length(intersect(unlist(sides[by_days]), unlist(sides[!by_days]))) > 0
  if (mixed) rep(FALSE, length(effects)) else by_days
}

# An effect: its value, what the sum gains for each unit of C and of T, the means, and its shared days. Savings enter by
# their derivatives -100 / C of T and 100 T / C^2 of C.
term_of <- function(runs, effect, paired, percent) {
  weight <- effect[[1]]
  pair <- effect[[2]]
  means <- if (paired) paired_means(runs, pair) else means_within_days(runs, pair)
  control <- means$control
  treated <- means$treated
  of_control <- if (percent) 100 * weight * treated / control^2 else -weight
  of_treated <- if (percent) -100 * weight / control else weight
  list(
    pair = vapply(pair, paste, "", collapse = "; "),
    gain = weight * (if (percent) 100 * (control - treated) / control else treated - control),
    of_control = of_control, of_treated = of_treated, means = means,
    days = runs_by_day(runs, pair),
    shared = of_control * means$control_shared + of_treated * means$treated_shared
  )
}

# Variance by days: what a day gives to all effects is added up before it is squared.
variance_by_days <- function(terms) {
  if (length(terms) == 0) return(c(variance = 0, df = Inf))
  gains <- lapply(terms, function(term) {
    k <- length(term$days)
    vapply(term$days, function(day) {
      of_control <- term$of_control * (mean(day[[1]]$value) - term$means$control)
      (of_control + term$of_treated * (mean(day[[2]]$value) - term$means$treated)) / sqrt(k * (k - 1))
    }, 0)
  })
  by_day <- tapply(unlist(gains), unlist(lapply(gains, names)), sum)
  squares <- vapply(gains, function(gain) sum(gain^2), 0)
  df <- sum(squares)^2 / sum(squares^2 / (lengths(gains) - 1))
  c(variance = sum(by_day^2), df = min(df, length(by_day) - 1))
}

# Variance by runs within days: a condition enters once, with all that it has in the effects.
variance_within_days <- function(terms) {
  if (length(terms) == 0) return(c(variance = 0, df = Inf))
  blocks <- do.call(rbind, unlist(lapply(terms, function(term) {
    lapply(1:2, function(side) {
      data.frame(
        condition = term$pair[side], day = names(term$days),
        gain = day_weights(term$days) * c(term$of_control, term$of_treated)[side],
        n = vapply(term$days, function(day) nrow(day[[side]]), 0),
        squares = vapply(term$days, function(day) squares_of(day[[side]]), 0)
      )
    })
  }), recursive = FALSE))
  gains <- aggregate(gain ~ condition + day, blocks, sum)
  own <- merge(gains, unique(blocks[c("condition", "day", "n", "squares")]))
  parts <- vapply(split(own, own$condition), function(one) {
    df <- sum(one$n - 1)
    c(sum(one$squares) / df * sum(one$gain^2 / one$n), df)
  }, c(0, 0))
  c(variance = sum(parts[1, ]), df = min(parts[2, ]))
}

# The sum with its interval, t and p; the degrees of freedom are Satterthwaite's over both kinds of effects. Nothing is
# claimed where the days of an effect allow no test, or where a saving has no bounds.
contrast_of <- function(runs, effects, percent) {
  by_days <- days_are_units(runs, effects)
  terms <- Map(function(effect, paired) term_of(runs, effect, paired, percent), effects, by_days)
  value <- sum(vapply(terms, function(term) term$gain, 0))
  unclaimed <- function(term) term$means$df == 0 || (percent && is.null(fieller(term$means)))
  if (any(vapply(terms, unclaimed, NA))) return(list(value = value))
  parts <- rbind(variance_by_days(terms[by_days]), variance_within_days(terms[!by_days]))
  parts <- parts[parts[, "variance"] > 0, , drop = FALSE]
  df <- satterthwaite_df(parts[, "variance"], parts[, "df"])
  shared <- Reduce(`+`, lapply(terms, function(term) term$shared))
  error <- sqrt(sum(parts[, "variance"]) + shared_covariance(shared, shared, LEVEL, df))
  half <- t_quantile(LEVEL, df) * error
  list(
    value = value, se = sqrt(sum(parts[, "variance"])), shared_se = shared_se(shared),
    ci_low = value - half, ci_high = value + half, df = df, t = value / error, p = two_sided_p(value / error, df)
  )
}

contrast <- function(runs) contrast_of(runs, EFFECTS, PERCENT)

# What was measured of a hypothesis: the change of a mean in percent of another, or of a saving in points.

# A change, which is less a saving, with its interval where there is one.
as_change <- function(saving) {
  found <- list(value = -saving$value)
  if (is.null(saving$ci_low)) return(found)
  c(found, saving[c("se", "shared_se", "df")], list(ci_low = -saving$ci_high, ci_high = -saving$ci_low))
}

change <- function(runs) as_change(saving_of(compare(runs, PAIR)))

# The last saving less the first in percentage points.
change_of_saving <- function(runs) as_change(contrast_of(runs, EFFECTS, TRUE))

# Holm's adjusted p (Holm 1979) of one test among those of its family; tests that have no p count all the same.

adjusted <- function(p_values) p.adjust(p_values, "holm", n = length(p_values) + WITHOUT_P)[[ASKED]]

adjusted_p <- function(runs) {
  list(value = adjusted(vapply(TESTS, function(pair) p_of(compare(runs, pair)), 0)))
}

adjusted_p_of_contrast <- function(runs) {
  list(value = adjusted(vapply(CONTRASTS, function(test) contrast_of(runs, test[[2]], test[[1]])$p, 0)))
}

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

# Satterthwaite's degrees of freedom; the fewest of any group where nothing scatters but by the last digits.
df_of_scatter <- function(savings) {
  if (all(of_each(savings, "variance") <= 1e-24)) return(min(of_each(savings, "df")))
  satterthwaite_df(of_each(savings, "variance"), of_each(savings, "df"))
}

# The mean saving: what a day does to all groups is added up before it is squared.
over_groups <- function(savings) {
  n <- length(savings)
  errors <- departures(savings)
  variance <- sum((colSums(errors) / n)^2) + sum(of_each(savings, "variance")[is_within(savings)]) / n^2
  df <- df_of_scatter(savings)
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
  df <- df_of_scatter(savings)
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
