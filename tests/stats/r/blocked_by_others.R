# The exact tests of blocked_data.csv's thirty designs by car and multcomp; writes blocked_by_others.csv beside itself.
#
#   Rscript blocked_by_others.R        (Debian: r-cran-car, r-cran-multcomp)
#
# With what the exact test holds fixed as a factor, on values, means of runs and means of days: car's F and multcomp's
# comparisons with the control.
here <- dirname(sub("--file=", "", grep("--file=", commandArgs(FALSE), value = TRUE)))
suppressMessages({library(car); library(multcomp)})
data <- read.csv(file.path(here, "blocked_data.csv"), colClasses = c(run = "character"))
results <- list()
for (name in unique(data$design)) {
  d <- data[data$design == name, ]
  d$condition <- factor(d$condition); d$day <- factor(d$day); d$session <- interaction(d$day, d$run, drop = TRUE)
  keep <- function(quantity, of, value) results[[length(results) + 1]] <<-
    data.frame(design = name, quantity = quantity, of = of, value = sprintf("%.17g", value))
  runs <- aggregate(value ~ condition + day + session, d, mean)
  days <- aggregate(value ~ condition + day, runs, mean)
  fixed <- list("value/day" = list(value ~ day + condition, d), "value/run" = list(value ~ session + condition, d),
                "run mean/day" = list(value ~ day + condition, runs),
                "day mean/nothing" = list(value ~ condition, days))
  for (layout in names(fixed)) {
    linear <- do.call(lm, fixed[[layout]])
    if (anyNA(coef(linear)) || df.residual(linear) == 0) next         # conditions not joined, or nothing left
    if (deviance(linear) < 1e-10 * sum(resid(lm(value ~ 1, fixed[[layout]][[2]]))^2)) next       # nothing scatters
    table <- Anova(linear, type = 2)
    keep("exact_f", layout, table["condition", "F value"]); keep("exact_df", layout, table["Residuals", "Df"])
    keep("exact_p", layout, table["condition", "Pr(>F)"])
    against <- glht(linear, linfct = mcp(condition = "Dunnett"))
    found <- summary(against, test = univariate())$test
    ends <- confint(against, calpha = univariate_calpha())$confint
    for (i in seq_along(found$coefficients)) {
      of <- paste0(layout, ":", sub(" - .*", "", names(found$coefficients)[i]))
      keep("exact_t", of, found$tstat[i]); keep("exact_p_of_t", of, found$pvalues[i])
      keep("exact_low", of, ends[i, "lwr"]); keep("exact_high", of, ends[i, "upr"])
    }
  }
}
write.csv(do.call(rbind, results), file.path(here, "blocked_by_others.csv"), row.names = FALSE, quote = FALSE)
