# Slopes through the origin over groups of unequal size, by clubSandwich: group, x and y of each design, then its CR2.
# Rscript slope_over_groups.R > slope_over_groups.csv   (Debian: r-cran-clubsandwich; R 4.2.2, clubSandwich 0.5.8)
suppressPackageStartupMessages(library(clubSandwich))
set.seed(20261129)
designs <- list(equal = c(4, 4, 4, 4), unequal = c(8, 4, 2, 2), most_in_one = c(12, 1, 1, 1), two = c(5, 3),
                six = c(8, 4, 4, 2, 2, 1), twelve = c(1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6))
cat("design,name,group,x,y\n")
for (name in names(designs)) {
  group <- rep(seq_along(designs[[name]]), designs[[name]])
  x <- signif(c(45, 57, 63, 67)[(seq_along(group) - 1) %% 4 + 1] + rnorm(length(group)), 6)
  y <- signif(1.06 * x * (1 + rnorm(length(designs[[name]]), 0, 0.02)[group]) + rnorm(length(group), 0, 0.5), 6)
  cat(sprintf("%s,data,%d,%.17g,%.17g\n", name, group, x, y), sep = "")
  found <- coef_test(lm(y ~ 0 + x), vcov = "CR2", cluster = group, test = "Satterthwaite")
  interval <- found$beta + c(-1, 1) * qt(0.975, found$df_Satt) * found$SE
  values <- c(slope = found$beta, se = found$SE, df = found$df_Satt, low = interval[1], high = interval[2])
  cat(sprintf("%s,%s,,%.17g,\n", name, names(values), values), sep = "")
}
