# One-way designs, balanced and clearly unbalanced, by car, emmeans, multcomp and effectsize: case, method, name, value.
# Rscript group_designs.R > group_designs.csv
#   (Debian: r-cran-car, r-cran-emmeans, r-cran-multcomp, r-cran-effectsize; R 4.2.2, car 3.1-1, emmeans 1.8.4-1,
#    multcomp 1.4-22, effectsize 0.8.3)
#
# effectsize looks for noncentralities by a simplex that stops at 1e-9 in p; beside its intervals stand those of
# `uniroot` at 1e-13 on tails summed (F) and integrated (t) by R itself, since `pf` keeps only 1e-9 of them. multcomp
# integrates at random: its own estimate of the error stands beside its p (its intervals hold to 0.001 of their level),
# and beside both what the double integral over the control's mean and the pooled scatter gives on a fine grid.
suppressPackageStartupMessages({library(car); library(emmeans); library(multcomp); library(effectsize)})
options(digits = 17, contrasts = c("contr.sum", "contr.poly"))
set.seed(20261122)
simulate <- function(n, step, sd = rep(1, length(n)), level = 40)
  setNames(lapply(seq_along(n), function(i) signif(level + step * (i - 1) + rnorm(n[i], 0, sd[i]), 6)),
           c("CE", paste0("AD", 50 * seq_len(length(n) - 1))))
cases <- list(
  balanced_3x8 = simulate(rep(8, 3), 0.7), balanced_4x6 = simulate(rep(6, 4), -0.5),
  balanced_5x5 = simulate(rep(5, 5), 0.4), balanced_5x3 = simulate(rep(3, 5), 1),
  unbalanced_3 = simulate(c(4, 11, 7), 0.8), unbalanced_4 = simulate(c(6, 3, 9, 5), -0.6),
  unbalanced_5 = simulate(c(12, 3, 7, 5, 9), 0.5), few_controls_5 = simulate(c(3, 12, 6, 9, 4), -0.7),
  unequal_scatter_3 = simulate(c(5, 12, 8), 1.5, c(3, 1, 2)),
  unequal_scatter_5 = simulate(c(12, 3, 7, 5, 9), 1, c(1, 5, 2, 4, 3)),
  no_effect = simulate(c(7, 4, 10), 0), far = simulate(c(5, 8, 3), 0.5, rep(0.5, 3), 1000))
row <- function(case, method, name, value) cat(sprintf("%s,%s,%s,%.17g\n", case, method, name, value))

f_tail <- function(f, df, df_error, lambda, lower) {
  j <- seq(0, qpois(1e-20, lambda / 2, lower.tail = FALSE) + 10)
  sum(dpois(j, lambda / 2) * pbeta(df * f / (df * f + df_error), df / 2 + j, df_error / 2, lower.tail = lower))
}
f_noncentrality <- function(f, df, df_error, lower) {
  surplus <- function(lambda) log(f_tail(f, df, df_error, lambda, lower) / 0.025)
  if ((surplus(0) > 0) != lower) return(0)
  uniroot(surplus, c(0, 20 * df * (f + 2)), extendInt = "yes", tol = 1e-13)$root
}
t_tail <- function(t, df, delta, lower) {
  log_weight <- function(s) log(2 * df * s) + dchisq(df * s * s, df, log = TRUE)
  side <- if (lower) 1 else -1
  ends <- sqrt(c(qchisq(1e-22, df), qchisq(1e-22, df, lower.tail = FALSE)) / df)
  integrate(function(s) exp(log_weight(s)) * pnorm(side * (t * s - delta)), ends[1], ends[2], rel.tol = 1e-13,
            subdivisions = 5000)$value
}
t_noncentrality <- function(t, df, lower)
  uniroot(function(delta) log(t_tail(t, df, delta, lower) / 0.025), t + c(-9, 9), extendInt = "yes", tol = 1e-13)$root

# P(no T of the treatments exceeds t): T shares the control's mean z and the scatter s.
dunnett_below <- function(t, n_control, n, df, two_sided) {
  z <- seq(-9, 9, length.out = 901); weight_z <- dnorm(z) * (z[2] - z[1])
  u <- seq(log(qchisq(1e-20, df) / df) / 2, log(qchisq(1e-20, df, lower.tail = FALSE) / df) / 2, length.out = 801)
  s <- exp(u)
  weight_s <- 2 * df * s * s * dchisq(df * s * s, df) * (u[2] - u[1])
  inside <- matrix(1, length(u), length(z))
  for (one in n) {
    shared <- sqrt(one / (one + n_control)); own <- sqrt(1 - shared^2)
    high <- pnorm(outer(t * s, shared * z, "-") / own)
    inside <- inside * (if (two_sided) high - pnorm(outer(-t * s, shared * z, "-") / own) else high)
  }
  sum(weight_s * (inside %*% weight_z))
}

cat("case,method,name,value\n")
for (case in names(cases)) {
  groups <- cases[[case]]; k <- length(groups); n <- lengths(groups)
  for (name in names(groups)) for (value in groups[[name]]) row(case, "data", name, value)
  data <- data.frame(y = unlist(groups, use.names = FALSE), g = factor(rep(names(groups), n), levels = names(groups)))
  fit <- aov(y ~ g, data)

  for (center in c("mean", "median")) {
    levene <- leveneTest(y ~ g, data, center = if (center == "mean") mean else median)
    row(case, paste0("levene_", center), "f", levene[1, "F value"])
    row(case, paste0("levene_", center), "p", levene[1, "Pr(>F)"])
  }
  bartlett <- bartlett.test(y ~ g, data)
  row(case, "bartlett", "chi_squared", bartlett$statistic); row(case, "bartlett", "p", bartlett$p.value)

  table <- Anova(lm(y ~ g, data), type = 2)
  method <- "car_type_2"
  row(case, method, "ss_between", table["g", "Sum Sq"]); row(case, method, "ss_within", table["Residuals", "Sum Sq"])
  row(case, method, "df_within", table["Residuals", "Df"]); row(case, method, "f", table["g", "F value"])
  row(case, method, "p", table["g", "Pr(>F)"])
  f <- table["g", "F value"]; within <- sum(n) - k
  eta <- eta_squared(fit, partial = FALSE, ci = 0.95, alternative = "two.sided", verbose = FALSE)
  omega <- omega_squared(fit, partial = FALSE, ci = 0.95, alternative = "two.sided", verbose = FALSE)
  row(case, "shares", "eta_squared", eta$Eta2); row(case, "shares", "omega_squared", omega$Omega2)
  row(case, "shares", "eta_low", eta$CI_low); row(case, "shares", "eta_high", eta$CI_high)
  row(case, "shares", "noncentrality_low", f_noncentrality(f, k - 1, within, FALSE))
  row(case, "shares", "noncentrality_high", f_noncentrality(f, k - 1, within, TRUE))

  welch <- oneway.test(y ~ g, data); f <- welch$statistic; df <- welch$parameter[2]
  row(case, "welch", "f", f); row(case, "welch", "df_within", df); row(case, "welch", "p", welch$p.value)
  eta <- effectsize(welch, type = "eta", ci = 0.95, alternative = "two.sided", verbose = FALSE)
  omega <- effectsize(welch, type = "omega", ci = 0.95, alternative = "two.sided", verbose = FALSE)
  row(case, "welch", "effectsize_eta", eta$Eta2); row(case, "welch", "effectsize_omega", omega$Omega2)
  row(case, "welch", "effectsize_low", eta$CI_low); row(case, "welch", "effectsize_high", eta$CI_high)
  row(case, "welch", "eta_squared", F_to_eta2(f, k - 1, within, ci = NULL)$Eta2_partial)
  row(case, "welch", "omega_squared", F_to_omega2(f, k - 1, within, ci = NULL)$Omega2_partial)
  row(case, "welch", "noncentrality_low", f_noncentrality(f, k - 1, df, FALSE))
  row(case, "welch", "noncentrality_high", f_noncentrality(f, k - 1, df, TRUE))

  means <- emmeans(fit, "g")
  pairs <- as.data.frame(summary(pairs(means, adjust = "tukey"), infer = TRUE))
  critical <- uniroot(function(q) ptukey(q, k, within, lower.tail = FALSE) - 0.05, c(1, 50), tol = 1e-13)$root
  row(case, "emmeans_tukey", "critical", critical)
  for (i in seq_len(nrow(pairs))) {
    pair <- gsub(" - ", "-", pairs$contrast[i])
    row(case, "emmeans_difference", pair, pairs$estimate[i]); row(case, "emmeans_t", pair, pairs$t.ratio[i])
    row(case, "emmeans_p", pair, pairs$p.value[i])
  }
  for (side in c("two.sided", "less", "greater")) {
    set.seed(1)
    compared <- glht(fit, linfct = mcp(g = "Dunnett"), alternative = side)
    found <- suppressWarnings(  # that the error is above abseps: it is written
      summary(compared, test = adjusted(type = "single-step", abseps = 1e-7, maxpts = 5e5))$test)
    row(case, "dunnett_error", side, attr(found$pvalues, "error"))
    for (i in seq_along(found$coefficients)) {
      name <- names(found$coefficients)[i]
      row(case, paste0("dunnett_", side), name, found$pvalues[i])
      t <- switch(side, two.sided = abs(found$tstat[i]), less = -found$tstat[i], greater = found$tstat[i])
      row(case, paste0("integrated_", side), name, 1 - dunnett_below(t, n[1], n[-1], within, side == "two.sided"))
      if (side == "two.sided") row(case, "dunnett_t", name, found$tstat[i])
    }
    if (side == "two.sided") {
      surplus <- function(t) dunnett_below(t, n[1], n[-1], within, TRUE) - 0.95
      row(case, "integrated", "critical", uniroot(surplus, c(1, 9), tol = 1e-13)$root)
      ends <- suppressWarnings(confint(compared, abseps = 1e-6, maxpts = 1e5)$confint)
      for (name in rownames(ends)) {
        row(case, "dunnett_low", name, ends[name, "lwr"]); row(case, "dunnett_high", name, ends[name, "upr"])
      }
    }
  }
  for (name in names(groups)[-1]) {
    a <- groups[[name]]; b <- groups$CE
    g <- hedges_g(a, b); t <- t.test(a, b, var.equal = TRUE)$statistic; df <- length(a) + length(b) - 2
    row(case, "cohens_d", name, cohens_d(a, b)$Cohens_d); row(case, "hedges_g", name, g$Hedges_g)
    row(case, "hedges_low", name, g$CI_low); row(case, "hedges_high", name, g$CI_high)
    row(case, "noncentrality_low", name, t_noncentrality(t, df, FALSE))
    row(case, "noncentrality_high", name, t_noncentrality(t, df, TRUE))
  }
}
