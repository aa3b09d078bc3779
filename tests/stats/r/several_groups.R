# Several groups by R: Games-Howell (formula on ptukey), Holm, TOST. Written to several_groups.csv: case, method, name,
# value.
# Rscript several_groups.R > several_groups.csv
options(digits = 17)
cases <- list(
  equal = list(CE = c(42.1, 39.8, 44.0, 41.5, 43.2), AD50 = c(36.9, 38.2, 35.1, 37.7, 36.0),
               AD100 = c(37.0, 39.5, 38.1, 36.2, 40.3), AD150 = c(41.0, 40.2, 43.9, 42.2, 39.1)),
  unequal = list(CE = c(42.1, 39.8, 44.0, 41.5, 43.2, 40.7, 42.9), AD50 = c(36.9, 38.2, 35.1),
                 AD100 = c(37.0, 39.5, 48.1, 31.2, 40.3), AD150 = c(41.0, 40.2, 43.9, 42.2, 39.1, 42.0, 41.1, 40.9)),
  little = list(a = c(1.01, 1.02, 1.04), b = c(1.00, 1.05, 1.03), c = c(1.02, 1.01, 1.05)))
row <- function(case, method, name, value) cat(sprintf("%s,%s,%s,%.17g\n", case, method, name, value))
cat("case,method,name,value\n")
for (case in names(cases)) {
  groups <- cases[[case]]
  k <- length(groups)
  for (i in 1:(k - 1)) for (j in (i + 1):k) {
    a <- groups[[j]]; b <- groups[[i]]
    va <- var(a) / length(a); vb <- var(b) / length(b)
    df <- (va + vb)^2 / (va^2 / (length(a) - 1) + vb^2 / (length(b) - 1))
    q <- abs(mean(a) - mean(b)) / sqrt((va + vb) / 2)
    pair <- paste(names(groups)[j], names(groups)[i], sep = "-")
    row(case, "games_howell_p", pair, ptukey(q, k, df, lower.tail = FALSE))
  }
  a <- groups[[2]]; b <- groups[[1]]
  for (equal in c(FALSE, TRUE)) {
    name <- if (equal) "student" else "welch"
    row(case, "tost_low", name, t.test(a, b, mu = -4, alternative = "greater", var.equal = equal)$p.value)
    row(case, "tost_high", name, t.test(a, b, mu = 4, alternative = "less", var.equal = equal)$p.value)
    ends <- t.test(a, b, conf.level = 0.9, var.equal = equal)$conf.int
    row(case, "tost_ci_low", name, ends[1]); row(case, "tost_ci_high", name, ends[2])
  }
}
p <- c(a = 0.01, b = 0.04, c = 0.03, d = 0.005, e = 0.04, f = 1e-200)
adjusted_p <- p.adjust(p, "holm")
for (name in names(p)) row("p_values", "holm", name, adjusted_p[name])
for (q in c(0.5, 2, 3.5, 5, 8)) for (k in c(2, 3, 6, 20)) for (df in c(2, 7.5, 30, Inf))
  row("range", "ptukey", paste(q, k, df, sep = "/"), ptukey(q, k, df, lower.tail = FALSE))
