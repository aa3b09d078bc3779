# lme4's search stops where the deviance no longer falls, at 1e-7 of the variances; Newton's method on its gradient
# goes on from there, so that what is compared is the estimate, not where a search stopped.
suppressMessages({library(lmerTest); library(numDeriv)})
keep_start <- function(fn, par, lower, upper, control) list(par = par, fval = fn(par), conv = 0, message = "kept")
quiet <- function(...) lmerControl(..., check.conv.singular = "ignore", check.conv.grad = "ignore",
                                   check.conv.hess = "ignore")
fit <- function(formula, d) {
  first <- lmer(formula, d, control = quiet())
  deviance_of <- lmer(formula, d, control = quiet(), devFunOnly = TRUE)
  theta <- getME(first, "theta")
  theta[theta < 1e-3] <- 0
  inner <- which(theta > 0)
  of <- function(part) { all <- theta; all[inner] <- part; deviance_of(all) }
  for (step in 1:6) if (length(inner))
    theta[inner] <- theta[inner] - solve(hessian(of, theta[inner]), grad(of, theta[inner]))
  stopifnot(theta >= 0, deviance_of(theta) <= deviance_of(getME(first, "theta")) + 1e-7)
  formula <- formula; start <- unname(theta)
  eval(bquote(lmer(.(formula), d, start = .(start), control = quiet(optimizer = "keep_start", calc.derivs = FALSE))))
}
