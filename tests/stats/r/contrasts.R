# Contrasts of condition means on shared days, by lm: 20 designs, their runs and what lm says of the contrast.
# Rscript contrasts.R > contrasts.csv   (base R 4.2.2)
#
# From four shared days on, lm(L ~ 1) on the contrasts L of the days' means; of savings, on what they are to first order.
# Within fewer days, lm(y ~ day) gives the scatter of a condition's runs, and days weigh as in lm(y ~ condition + day).
options(digits = 17)
set.seed(20261128)
cat("design,what,condition,day,value\n")
row <- function(design, what, condition, day, value)
  cat(sprintf("%d,%s,%s,%s,%.17g\n", design, what, condition, day, value))

for (design in 1:20) {
  k <- if (design <= 14) sample(4:8, 1) else sample(1:3, 1)
  percent <- design %% 2 == 0
  levels <- sample(2:6, 1)
  groups <- if (design %% 3 == 0) 2 else 1
  # effects: every treated level of a group against the control of the group
  effects <- expand.grid(level = seq_len(levels), group = seq_len(groups))
  gain <- 50 * effects$level
  weight <- if (groups == 2) ifelse(effects$group == 1, 1, -1) / levels else
    if (design %% 4 == 1) rep(1 / levels, levels) else (gain - mean(gain)) / sum((gain - mean(gain))^2)
  conditions <- c(paste0("g", seq_len(groups), "c"), paste0("g", effects$group, "t", effects$level))
  day_effect <- rnorm(k, 0, 3)
  runs <- do.call(rbind, lapply(seq_along(conditions), function(i) do.call(rbind, lapply(seq_len(k), function(d) {
    n <- sample((if (k < 4) 2 else 1):4, 1)
    level <- 40 - (i > groups) * (3 + 0.5 * i)
    data.frame(condition = conditions[i], day = paste0("d", d), y = signif(level + day_effect[d] + rnorm(n, 0, 1 + i / 4), 6))
  }))))
  for (i in seq_len(nrow(runs))) row(design, "run", runs$condition[i], runs$day[i], runs$y[i])
  means <- tapply(runs$y, list(runs$day, runs$condition), mean)
  counts <- tapply(runs$y, list(runs$day, runs$condition), length)
  treated <- paste0("g", effects$group, "t", effects$level); control <- paste0("g", effects$group, "c")
  for (j in seq_along(treated)) row(design, "weight", treated[j], control[j], weight[j])
  if (k >= 4) {
    of_day <- sapply(seq_along(treated), function(j) {
      t <- means[, treated[j]]; c <- means[, control[j]]
      if (!percent) return(t - c)
      rho <- mean(t) / mean(c)
      100 * (1 - rho) - 100 * (t - rho * c) / mean(c)
    })
    fit <- lm(as.vector(of_day %*% weight) ~ 1)
    s <- summary(fit)$coefficients
    value <- s[1]; se <- s[2]; df <- fit$df.residual
  } else {
    value <- 0; part <- 0 * means
    for (j in seq_along(treated)) {
      n <- counts[, control[j]]; m <- counts[, treated[j]]; w <- n * m / (n + m); w <- w / sum(w)
      t <- sum(w * means[, treated[j]]); c <- sum(w * means[, control[j]])
      value <- value + weight[j] * (if (percent) 100 * (1 - t / c) else t - c)
      part[, treated[j]] <- part[, treated[j]] + weight[j] * w * (if (percent) -100 / c else 1)
      part[, control[j]] <- part[, control[j]] + weight[j] * w * (if (percent) 100 * t / c^2 else -1)
    }
    fits <- sapply(conditions, function(one) {
      of <- runs[runs$condition == one, ]
      fit <- if (k > 1) lm(y ~ day, of) else lm(y ~ 1, of)
      c(summary(fit)$sigma^2 * sum(part[, one]^2 / counts[, one]), fit$df.residual)
    })
    se <- sqrt(sum(fits[1, ])); df <- min(fits[2, fits[1, ] > 0])
  }
  q <- qt(0.975, df)
  found <- c(percent = percent, value = value, se = se, df = df, t = value / se, p = 2 * pt(-abs(value / se), df),
             low = value - q * se, high = value + q * se)
  for (name in names(found)) row(design, name, "", "", found[name])
}
