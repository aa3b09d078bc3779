"""What every least-squares fit says of itself, whatever its columns are."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

from data_schema.errors import InputRefused
from data_schema.rounding import alpha_beside
from data_schema.vocabulary import Undefined
from stats.exact.finite import Interval
from stats.exact.tails import f_upper, t_two_sided
from stats.lines.coefficients import Coefficient, one_by_one
from stats.results import Result
from stats.wording import half_width, interval_text, missing_text, number_text, p_text, share_text, with_unit

INTERCEPT = "intercept"
EXACT = Undefined("the fit is exact, so that nothing measures the scatter")


@dataclass(frozen=True, slots=True)
class Fit(Result):
    """A least-squares fit; a coefficient's unit is that of the response over that of its column."""

    names: tuple[str, ...]
    """Of the coefficients: "intercept" first where there is one; shape (p,)."""
    coefficients: tuple[float, ...]
    """In the order of `names`, shape (p,)."""
    standard_errors: tuple[float, ...] | Undefined
    """Of the coefficients, in their units, shape (p,); 0 where the fit is exact."""
    ci: tuple[tuple[float, float], ...] | Undefined
    """Student's interval of each coefficient, in its unit, shape (p, 2); undefined for an exact fit."""
    level: float
    """Level of the intervals."""
    t: tuple[float, ...] | Undefined
    """Coefficient over standard error, shape (p,); undefined for an exact fit."""
    p: tuple[float, ...] | Undefined
    """Two-sided, of each coefficient being 0; shape (p,)."""
    covariance: tuple[tuple[float, ...], ...] | Undefined
    """Of the coefficients, shape (p, p), in the products of their units."""
    r_squared: float | Undefined
    """About the mean with an intercept, about 0 without; 0 to 1."""
    f: float | Undefined
    """Of all coefficients but the intercept being 0, with `df_model` and `df`."""
    f_p: float | Undefined
    """P(F >= f)."""
    residual_sd: float | Undefined
    """sqrt(SS_residual / df), in the unit of the response."""
    ss_residual: float | Undefined
    """In the response's unit squared: exactly 0 for an exact fit, and for no other."""
    condition: float
    """2-norm condition of the centred columns scaled to one length: digits lost to the design, about its log10."""
    df_model: int
    """Number of coefficients without the intercept."""
    df: int
    """n minus the number of coefficients."""
    n: int
    """Number of values."""
    missing: int = field(default=0, kw_only=True)
    """Rows left out because a value in them was NaN."""
    times: tuple[str, ...] = field(default=(), kw_only=True)
    """Columns that were given as moments or durations, with their unit in the fit: "start in s since 1970 UTC"."""
    response_time: str | None = field(default=None, kw_only=True)
    """The unit of a response that was given as moments or durations, "s since 1970 UTC" or "s"; else None."""

    @property
    def log10_p(self) -> tuple[float, ...] | Undefined:
        """Decimal logarithms of `p`, shape (p,), right at any size."""
        return self.t if isinstance(self.t, Undefined) else tuple(t_two_sided(t, self.df).log10_p for t in self.t)

    @property
    def f_log10_p(self) -> float | Undefined:
        """Decimal logarithm of `f_p`, right at any size."""
        return self.f if isinstance(self.f, Undefined) else f_upper(self.f, self.df_model, self.df).log10_p

    def as_fields(self) -> dict[str, Any]:
        """Return the fields by name, for a fit that says more."""
        return {one.name: getattr(self, one.name) for one in fields(Fit)}

    def rows(self) -> tuple[Coefficient, ...]:
        """Return the coefficients, for `to_frame`."""
        of_each = self.standard_errors, self.t, self.p, self.log10_p, self.ci
        return one_by_one(self.names, self.coefficients, *of_each, self._inflations())

    def _inflations(self) -> tuple[float | Undefined, ...]:
        """Return the variance inflation of each coefficient, where the fit has such."""
        return (Undefined("this fit has no columns of their own"),) * len(self.names)

    def spread(self, what: str) -> tuple[tuple[float, ...], float]:
        """Return standard errors and residual standard deviation of what is nothing without them.

        Raises `InputRefused` where one of them is undefined.
        """
        errors, sd = self.standard_errors, self.residual_sd
        if isinstance(errors, Undefined) or isinstance(sd, Undefined):
            reason = next(part.reason for part in (errors, sd) if isinstance(part, Undefined))
            raise InputRefused(f"{what} has no uncertainty, because {reason}: change units.")
        return errors, sd

    def intervals(self) -> tuple[Interval | Undefined, ...]:
        """Return the interval of each coefficient, shape (p,)."""
        return (self.ci,) * len(self.names) if isinstance(self.ci, Undefined) else self.ci

    def sentence(self, response: str = "the response", unit: str = "") -> str:
        """Return the fit in words: each coefficient with interval, t, df and p; R squared, residual SD, n."""
        parts, logs = [], self.log10_p
        for row, (name, value) in enumerate(zip(self.names, self.coefficients, strict=True)):
            interval = self.ci if isinstance(self.ci, Undefined) else self.ci[row]
            text = f"{name} {number_text(value, 6, half_width(interval))}"
            inside = []
            if not isinstance(interval, Undefined):
                inside.append(interval_text(interval, self.level))
            if not isinstance(self.t, Undefined) and not isinstance(self.p, Undefined):
                log10_p = logs if isinstance(logs, Undefined) else logs[row]
                inside.append(
                    f"t({self.df}) = {number_text(self.t[row])}, "
                    f"{p_text(self.p[row], log10_p, alpha_beside(self.level))}"
                )
            parts.append(f"{text} ({', '.join(inside)})" if inside else text)
        about = [f"R squared {share_text(self.r_squared, 6)}"]
        if not isinstance(self.f, Undefined):
            test = f"F({self.df_model}, {self.df}) = {number_text(self.f)}"
            about.append(f"{test}, {p_text(self.f_p, self.f_log10_p, alpha_beside(self.level))}")
        if isinstance(self.residual_sd, Undefined):
            about.append(f"no standard errors, because {self.residual_sd.reason}")
        else:
            about.append(f"residual SD {number_text(self.residual_sd)}{with_unit(unit)}")
            if isinstance(self.ci, Undefined):
                about.append(f"no intervals, because {self.ci.reason}")
        times = self.times if self.response_time is None else (f"{response} in {self.response_time}", *self.times)
        n = f"n = {self.n}{missing_text(self.missing)}{''.join(f'; {one}' for one in times)}"
        return f"Least squares of {response}: {'; '.join(parts)}; {', '.join(about)}, {n}."
