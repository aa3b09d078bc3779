from matplotlib import font_manager, rcParams
from matplotlib.figure import Figure

from reports.figures.kind import FORMS, write_figure
from reports.figures.style import FAMILY, figure_font, new_figure, publication_style

WORDS = "Yes, AV Te: k = 1091 N/m − 12 × 3 °C 包 é ß"


def test_the_font_is_dejavu_sans_letter_by_letter():
    assert figure_font() == FAMILY
    path = font_manager.findfont(FAMILY, fallback_to_default=False)
    made, source = (font_manager.get_font(name) for name in (path, font_manager.findfont("DejaVu Sans")))
    simple = {code for code in source.get_charmap() if 0x20 <= code < 0x600 or 0x1E00 <= code < 0x2800}
    assert len(simple) > 2000
    assert simple <= made.get_charmap().keys() <= source.get_charmap().keys()


def test_words_are_as_wide_as_in_dejavu_sans():
    with publication_style():
        assert rcParams["font.family"] == [FAMILY]
        figure = Figure()
        for weight in ("normal", "bold"):
            widths = {
                figure.text(0, 0, WORDS, family=family, weight=weight).get_window_extent().width
                for family in (FAMILY, "DejaVu Sans")
            }
            assert len(widths) == 1


def test_labels_that_leave_the_axes_no_room_are_drawn_without_a_warning(tmp_path):
    """Warnings are errors here: a user of absurd numbers read matplotlib's on the terminal."""
    for form in FORMS:
        with publication_style():
            figure = new_figure(3.5, 2.0)
            figure.subplots().set_yticks([0, 1], ["1" * 200] * 2)
        write_figure(figure, tmp_path / f"figure{form}")
        assert (tmp_path / f"figure{form}").stat().st_size > 1000
