import dataclasses

from reports.naming import control_name, formula_text, group_name, levels_name, treatment_label, treatment_name
from reports.results import Factor, Level
from tests.helpers.wording import says
from tests.reports.made import plain


def test_formulas_between_gains_and_physical_values(content):
    formulas = [plain(formula_text(factor)) for factor in content.factors]
    assert formulas == ["", "k = 2.56 g + 67.36 N/m", "d = 3.32 g + 19.67 kg/s; gain 0 is CE and stands for 0"]


def test_names_of_groups(content):
    says(plain(group_name(content, content.conditions[6])), "small foot", "1091 N/m")
    says(plain(group_name(content, content.conditions[6], gain=True)), "small foot", "1091 N/m", "400")
    says(plain(levels_name(content, {"k_gain": "300"})), "835 N/m")
    assert levels_name(content, {"surface": "sand"}) == "surface sand"


LOAD = Factor("load", "Load", unit="kg", control="0", swept=True)


def loaded(content, *labels, factor=LOAD):
    """The first group's conditions with a load in place of the active-damping gain."""
    made = [
        dataclasses.replace(c, levels=(*c.levels[:2], Level("load", label, float(label), "kg")), control=label == "0")
        for c, label in zip(content.conditions, labels, strict=False)
    ]
    return dataclasses.replace(content, factors=(*content.factors[:2], factor), conditions=tuple(made))


def test_the_treatment_is_named_by_its_levels(content):
    group = {"foot": "small", "k_gain": "300"}
    assert plain(treatment_name(loaded(content, "0", "2"), group)) == "load = 2 kg"
    says(plain(treatment_name(loaded(content, "0", "2", "3"), group)), "load = 2", "3 kg")
    many = loaded(content, "0", "1", "2", "3", "4")
    says(plain(treatment_name(many, group)), "4 levels")
    assert treatment_name(many, {"foot": "large"}) == "the treatment"
    says(plain(control_name(many)), "the control", "0 kg")
    gain = dataclasses.replace(LOAD, slope=2.0, offset=0.0)
    says(plain(control_name(loaded(content, "0", "2", factor=gain))), "the control (gain", "0")
    surface = Factor("surface", "Surface", control="sand", swept=True)
    gravel, mud = (Level("surface", name) for name in ("gravel", "mud"))
    one, two = (dataclasses.replace(c, control=False) for c in content.conditions[:2])
    of = [dataclasses.replace(c, levels=(*c.levels[:2], level)) for c, level in ((one, gravel), (two, mud))]
    both = dataclasses.replace(content, factors=(*content.factors[:2], surface), conditions=tuple(of))
    only = dataclasses.replace(both, conditions=tuple(of[:1]))
    assert (treatment_name(only, group), treatment_label(only)) == ("gravel", "gravel")
    assert (treatment_name(both, group), treatment_label(both)) == ("gravel and mud", "treatment")


def test_treatment_and_control_are_called_as_labbook_toml_does(content):
    assert (treatment_name(content, {}), control_name(content)) == ("active damping", "CE")
    unnamed = dataclasses.replace(content.factors[2], treatment="", control_name="")
    other = dataclasses.replace(content, factors=(*content.factors[:2], unnamed))
    says(plain(treatment_name(other, {})), "the treatment", "levels of the active-damping coefficient")
    assert plain(control_name(other)) == "the control (gain 0)"
