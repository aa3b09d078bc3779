# Natural logarithms of JZS Bayes factors by R's BayesFactor; bayes_factor.csv.
#
#   Rscript bayes_factor.R        (Debian: r-cran-bayesfactor 0.9.12-4.4)
suppressMessages(library(BayesFactor))
here <- dirname(sub("--file=", "", grep("--file=", commandArgs(FALSE), value = TRUE)))
cases <- expand.grid(t = c(0, .7, -2.5, 4, 12), n_a = c(3, 20, 150), n_b = c(0, 4, 60), scale = c(sqrt(.5), 1))
cases$log_bf <- sprintf("%.17g", mapply(function(t, a, b, r) ttest.tstat(t, a, b, rscale = r)[["bf"]],
                                        cases$t, cases$n_a, cases$n_b, cases$scale))
cases$scale <- sprintf("%.17g", cases$scale)
write.csv(cases, file.path(here, "bayes_factor.csv"), row.names = FALSE, quote = FALSE)
