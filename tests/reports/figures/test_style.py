from reports.figures.kind import FORMS, write_figure
from reports.figures.style import new_figure, publication_style


def test_labels_that_leave_the_axes_no_room_are_drawn_without_a_warning(tmp_path):
    """Warnings are errors here: a user of absurd numbers read matplotlib's on the terminal."""
    for form in FORMS:
        with publication_style():
            figure = new_figure(3.5, 2.0)
            figure.subplots().set_yticks([0, 1], ["1" * 200] * 2)
        write_figure(figure, tmp_path / f"figure{form}")
        assert (tmp_path / f"figure{form}").stat().st_size > 1000
