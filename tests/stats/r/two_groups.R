# Two groups and the spread of several, by base R, car and effectsize.
# Rscript tests/stats/r/two_groups.R > tests/stats/r/two_groups.csv
suppressPackageStartupMessages({ library(car); library(effectsize) })
say <- function(case, quantity, value) cat(sprintf("%s,%s,%.17g\n", case, quantity, value))
cases <- list(
  six_five = list(c(42.1, 39.8, 44.0, 41.2, 40.5, 43.3), c(36.9, 38.2, 35.1, 37.7, 36.0)),
  three_three = list(c(1.2, 3.1, 2.6), c(0.7, 1.9, 1.1)),
  unequal = list(c(0, 30, -25, 40, -35, 10), c(36.9, 38.2, 35.1, 37.7, 36.0, 37.1, 38.8, 35.9)),
  far = list(c(1001.1, 1001.3, 1001.2, 1001.25), c(1.4, 1.1, 1.2, 1.9, 1.3)),
  little = list(c(5.1, 4.8, 5.3, 5.0, 4.9, 5.2, 5.15), c(5.05, 4.85, 5.25, 5.1, 4.95, 5.0))
)
cat("case,quantity,value\n")
for (name in names(cases)) {
  a <- cases[[name]][[1]]; b <- cases[[name]][[2]]
  for (i in seq_along(a)) say(name, "a", a[i])
  for (i in seq_along(b)) say(name, "b", b[i])
  s <- t.test(a, b, var.equal = TRUE); w <- t.test(a, b)
  say(name, "student_t", s$statistic); say(name, "student_p", s$p.value)
  say(name, "student_low", s$conf.int[1]); say(name, "student_high", s$conf.int[2])
  say(name, "welch_t", w$statistic); say(name, "welch_df", w$parameter); say(name, "welch_p", w$p.value)
  say(name, "welch_low", w$conf.int[1]); say(name, "welch_high", w$conf.int[2])
  v <- var.test(a, b)
  say(name, "f", v$statistic); say(name, "f_p", v$p.value); say(name, "f_low", v$conf.int[1]); say(name, "f_high", v$conf.int[2])
  y <- c(a, b); g <- factor(rep(c("a", "b"), c(length(a), length(b))))
  say(name, "brown_forsythe_p", leveneTest(y, g, center = median)[1, 3])
  say(name, "brown_forsythe_f", leveneTest(y, g, center = median)[1, 2])
  say(name, "levene_p", leveneTest(y, g, center = mean)[1, 3])
  say(name, "bartlett", bartlett.test(y, g)$statistic); say(name, "bartlett_p", bartlett.test(y, g)$p.value)
  h <- hedges_g(a, b)
  say(name, "hedges_g", h$Hedges_g); say(name, "hedges_g_low", h$CI_low); say(name, "hedges_g_high", h$CI_high)
}
for (f in list(c(3, 2, 27), c(0.5, 3, 20), c(21, 8, 18000), c(150, 4, 45), c(9.2, 1, 12))) {
  e <- F_to_eta2(f[1], f[2], f[3], ci = 0.95, alternative = "two.sided")
  name <- sprintf("F:%g:%g:%g", f[1], f[2], f[3])
  say(name, "effectsize_low", e$CI_low); say(name, "effectsize_high", e$CI_high)
}
