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
