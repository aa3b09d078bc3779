# Power of t-tests, ANOVA and equivalence tests by R: stats::power.t.test, pwr, and integrals of its own; power.csv.
#
#   Rscript power.R        (Debian: r-base-core, r-cran-pwr; R 4.2.2, pwr 1.3-0)
suppressMessages(library(pwr))
here <- dirname(sub("--file=", "", grep("--file=", commandArgs(FALSE), value = TRUE)))
rows <- list()
keep <- function(test, value, ...) rows[[length(rows) + 1]] <<- data.frame(test = test, ..., power = sprintf("%.17g", value))
column <- function(difference = "", sd = "", sd_b = "", n_a = "", n_b = "", alpha = "", sides = "", low = "", high = "", means = "")
  list(difference = difference, sd = sd, sd_b = sd_b, n_a = n_a, n_b = n_b, alpha = alpha, sides = sides, low = low, high = high, means = means)
tell <- function(test, value, columns) do.call(keep, c(list(test, value), columns))
for (difference in c(0, 0.2, 0.8, 3)) for (n in c(2, 3, 5, 25, 400)) for (alpha in c(.05, .001)) {
  for (sides in 1:2) {
    value <- power.t.test(n, difference, 1.3, alpha, type = "two.sample", strict = TRUE,
                          alternative = c("one.sided", "two.sided")[sides])$power
    tell("t", value, column(difference, 1.3, "", n, n, alpha, sides))
    other <- pwr.t2n.test(n, n + 7, difference / 1.3, alpha, alternative = c("greater", "two.sided")[sides])$power
    tell("t", other, column(difference, 1.3, "", n, n + 7, alpha, sides))
  }
}
for (means in list(c(0, 0, 1), c(1, 2, 3, 4), c(0, .1), c(0, 0, 0, 0, 2.5))) for (n in c(2, 5, 25, 200)) for (alpha in c(.05, .001))
  tell("anova", power.anova.test(length(means), n, var(means), 1.7^2, alpha)$power,
       column(sd = 1.7, n_a = n, alpha = alpha, means = paste(means, collapse = " ")))
# Welch: both variances integrated over, one after the other.
normal_part <- function(s_a, s_b, case) with(case, {
  v_a <- s_a * sd^2 / n_a; v_b <- s_b * sd_b^2 / n_b
  df <- (v_a + v_b)^2 / (v_a^2 / (n_a - 1) + v_b^2 / (n_b - 1))
  c <- qt(alpha / 2, df, lower.tail = FALSE) * sqrt(v_a + v_b); true <- sqrt(sd^2 / n_a + sd_b^2 / n_b)
  pnorm((difference - c) / true) + pnorm((-difference - c) / true)
})
welch <- function(case) with(case, {
  inner <- function(x) integrate(function(y) normal_part(x, y, case) * dchisq(y * (n_b - 1), n_b - 1) * (n_b - 1), 0, Inf,
                                 rel.tol = 1e-10, subdivisions = 1000)$value
  integrate(function(x) sapply(x, inner) * dchisq(x * (n_a - 1), n_a - 1) * (n_a - 1), 0, Inf, rel.tol = 1e-9,
            subdivisions = 1000)$value
})
for (case in list(list(5, 20, 1, 2), list(20, 5, 1, 2), list(4, 4, 1, 1), list(10, 10, 3, 1), list(25, 10, .5, 2)))
  for (difference in c(0, 1, 3)) {
    all <- list(n_a = case[[1]], n_b = case[[2]], sd = case[[3]], sd_b = case[[4]], difference = difference, alpha = .05)
    tell("welch", welch(all), column(difference, all$sd, all$sd_b, all$n_a, all$n_b, .05, 2))
  }
# Equivalence: the estimated standard deviation integrated over.
for (n in c(2, 3, 5, 12, 50)) for (difference in c(0, .3, 1)) for (alpha in c(.05, .01)) {
  df <- 2 * n - 2; se <- 1.1 * sqrt(2 / n); t <- qt(1 - alpha, df); low <- -1; high <- 1.4
  top <- (high - low) / (2 * se * t)
  value <- integrate(function(u) (pnorm((high - difference) / se - t * u) - pnorm((low - difference) / se + t * u)) *
                       dchisq(u^2 * df, df) * 2 * u * df, 0, top, rel.tol = 1e-11, subdivisions = 2000)$value
  tell("equivalence", value, column(difference, 1.1, "", n, n, alpha, "", low, high))
}
write.csv(do.call(rbind, rows), file.path(here, "power.csv"), row.names = FALSE, quote = FALSE)
