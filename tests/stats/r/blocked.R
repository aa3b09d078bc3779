# Thirty designs of conditions over days, analysed by lmerTest; writes blocked_data.csv and blocked.csv beside itself.
#
#   Rscript blocked.R        (Debian: r-cran-lmertest, r-cran-emmeans; R 4.2.2, lme4 1.1-31, lmerTest 3.1-3, emmeans 1.8.4)
suppressMessages(library(emmeans))
set.seed(20261121)
here <- dirname(sub("--file=", "", grep("--file=", commandArgs(FALSE), value = TRUE)))
source(file.path(here, "refined_fit.R"))

simulate <- function(cells, k, day_sd, run_sd = 0, sd = 1, level = 10, effect = 0.5) {
  days <- unique(cells$day); runs <- unique(paste(cells$day, cells$run))
  of_day <- setNames(rnorm(length(days), 0, day_sd), days)
  of_run <- setNames(rnorm(length(runs), 0, run_sd), runs)
  y <- level + effect * sd * as.integer(factor(cells$condition)) + of_day[as.character(cells$day)] +
    of_run[paste(cells$day, cells$run)] + rnorm(nrow(cells), 0, sd)
  cells$value <- signif(y, 7)
  cells
}
crossed <- function(k, days, times) expand.grid(time = 1:times, condition = letters[1:k], day = 1:days, run = 1)
without <- function(cells, share) cells[sort(sample(nrow(cells), round((1 - share) * nrow(cells)))), ]
nested <- function(k, days, runs, times) {  # one condition a run
  cells <- expand.grid(time = 1:times, again = 1:runs, condition = letters[1:k], day = 1:days)
  cells$run <- paste0(cells$condition, cells$again)
  cells
}
shared <- function(k, days, runs, times) expand.grid(time = 1:times, condition = letters[1:k], run = 1:runs, day = 1:days)
own_days <- function(k, days, times) {      # each condition on days of its own
  cells <- expand.grid(time = 1:times, day = 1:(k * days), run = 1)
  cells$condition <- letters[(cells$day - 1) %% k + 1]
  cells
}
level_days <- function(cells) {             # days made equal, so that REML puts their variance at 0
  cells$value <- signif(cells$value - ave(cells$value, cells$day) + mean(cells$value), 7)
  cells
}
level_runs <- function(cells) {             # runs made equal within days and conditions
  cells$value <- signif(cells$value - ave(cells$value, cells$day, cells$run) + ave(cells$value, cells$condition) +
                        ave(cells$value, cells$day) - mean(cells$value), 7)
  cells
}
designs <- list(
  balanced_2x2 = simulate(crossed(2, 2, 5), 2, 1), balanced_2x3 = simulate(crossed(2, 3, 5), 2, 1),
  balanced_3x5 = simulate(crossed(3, 5, 4), 3, 1), balanced_5x6 = simulate(crossed(5, 6, 3), 5, 2),
  balanced_single = simulate(crossed(4, 6, 1), 4, 1), balanced_large_day = simulate(crossed(3, 4, 5), 3, 30),
  balanced_small_unit = simulate(crossed(3, 4, 5), 3, .03, sd = .01, level = .15),
  balanced_offset = simulate(crossed(2, 4, 6), 2, 1, level = 1000),
  balanced_large_unit = simulate(crossed(3, 4, 5), 3, 30, sd = 20, level = 100),
  unbalanced_2x3 = simulate(without(crossed(2, 3, 6), .3), 2, 1),
  unbalanced_3x4 = simulate(without(crossed(3, 4, 6), .4), 3, 1),
  unbalanced_3x6 = simulate(without(crossed(3, 6, 3), .5), 3, 2),
  unbalanced_4x5 = simulate(without(crossed(4, 5, 2), .4), 4, .7),
  unbalanced_5x6 = simulate(without(crossed(5, 6, 10), .3), 5, .3),
  unbalanced_2x2 = simulate(without(crossed(2, 2, 9), .5), 2, 3),
  missing_cells = simulate(subset(crossed(3, 5, 3), !(condition == "a" & day > 3 | condition == "c" & day < 3)), 3, 1),
  incomplete_pairs = simulate(subset(crossed(3, 6, 3), (day %% 3 == 0) != (condition == "a") | condition == "b"), 3, 1),
  confounded_balanced = simulate(own_days(2, 4, 5), 2, 1),
  confounded_unbalanced = simulate(without(own_days(3, 3, 6), .4), 3, 1),
  partly_confounded = simulate(subset(crossed(3, 6, 4), (day <= 3) == (condition != "c")), 3, 1),
  nested_balanced = simulate(nested(2, 4, 3, 4), 2, 1, .7),
  nested_one_run = simulate(nested(3, 5, 1, 4), 3, 1, .5),
  nested_unbalanced = simulate(without(nested(3, 4, 2, 5), .4), 3, 1, 1),
  nested_shared_runs = simulate(without(shared(2, 4, 3, 3), .2), 2, 1, .8),
  nested_large = simulate(without(nested(4, 6, 3, 8), .25), 4, 5, 2, sd = 3, level = 300),
  zero_day_balanced = level_days(simulate(crossed(3, 4, 5), 3, 0)),
  zero_day_unbalanced = level_days(simulate(without(crossed(3, 5, 4), .4), 3, 0)),
  zero_day_nested = level_days(simulate(without(nested(2, 5, 2, 4), .2), 2, 0, 1)),
  zero_run_nested = level_runs(simulate(without(nested(2, 5, 3, 4), .2), 2, 2, 0)),
  zero_both = level_days(level_runs(simulate(nested(2, 4, 2, 4), 2, 0, 0))))
stopifnot(length(designs) == 30)

rows <- list(); results <- list()
for (name in names(designs)) {
  d <- designs[[name]]
  has_runs <- grepl("nested|zero_run|zero_both", name)
  rows[[name]] <- data.frame(design = name, value = d$value, condition = d$condition, day = d$day,
                             run = if (has_runs) d$run else "")
  d$condition <- factor(d$condition); d$day <- factor(d$day); d$session <- interaction(d$day, d$run, drop = TRUE)
  model <- if (has_runs) fit(value ~ condition + (1 | day) + (1 | session), d)
           else fit(value ~ condition + (1 | day), d)
  spread <- as.data.frame(VarCorr(model))
  get <- function(group) { v <- spread$vcov[spread$grp == group]; if (length(v)) v else NA }
  table <- anova(model)
  keep <- function(quantity, of, value) results[[length(results) + 1]] <<-
    data.frame(design = name, quantity = quantity, of = of, value = sprintf("%.17g", value))
  keep("variance", "day", get("day")); if (has_runs) keep("variance", "run", get("session"))
  keep("variance", "residual", get("Residual")); keep("criterion", "", REMLcrit(model))
  keep("f", "", table[["F value"]]); keep("df_within", "", table[["DenDF"]]); keep("p_of_f", "", table[["Pr(>F)"]])
  coefs <- summary(model)$coefficients; ends <- confint(emmeans(model, "condition", lmer.df = "satterthwaite"))
  against <- as.data.frame(contrast(emmeans(model, "condition", lmer.df = "satterthwaite"), "trt.vs.ctrl1",
                                    adjust = "none", infer = TRUE))
  for (i in 2:nlevels(d$condition)) {
    of <- levels(d$condition)[i]
    keep("difference", of, coefs[i, "Estimate"]); keep("difference_se", of, coefs[i, "Std. Error"])
    keep("difference_df", of, coefs[i, "df"]); keep("t", of, coefs[i, "t value"]); keep("p", of, coefs[i, "Pr(>|t|)"])
    keep("difference_low", of, against$lower.CL[i - 1]); keep("difference_high", of, against$upper.CL[i - 1])
  }
  for (i in 1:nlevels(d$condition)) {
    of <- levels(d$condition)[i]
    keep("mean", of, ends$emmean[i]); keep("mean_se", of, ends$SE[i]); keep("mean_df", of, ends$df[i])
    keep("mean_low", of, ends$lower.CL[i]); keep("mean_high", of, ends$upper.CL[i])
  }
}
write.csv(do.call(rbind, rows), file.path(here, "blocked_data.csv"), row.names = FALSE, quote = FALSE)
write.csv(do.call(rbind, results), file.path(here, "blocked.csv"), row.names = FALSE, quote = FALSE)
