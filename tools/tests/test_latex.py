"""Tables as LaTeX sets them: nothing leaves the page, whatever stands in them."""

import shutil
import subprocess

import pandas as pd
import pytest

from musclebench.paper.published import read_published
from musclebench.results.run_folder import read_runs
from musclebench.tables import paper_tables, table_formats
from musclebench.tables.table_formats import Column, Table

DOCUMENT = "\\documentclass[a4paper,twocolumn]{article}\n\\usepackage{booktabs}\n\\begin{document}\n\\input{table}\n\\end{document}\n"
FAULTS = ("Overfull", "Float too large", "Missing", "Undefined")


@pytest.fixture
def tables(fake_raw) -> dict[str, Table]:
    """The paper's, and one that is as wide and as long as they come: all columns, many muscles, odd names."""
    runs, paper = read_runs(fake_raw), read_published()
    memory, times = paper_tables.memory_table(runs, paper), paper_tables.time_table(runs, paper)
    many = pd.concat([times.rows.assign(muscle=times.rows["muscle"] + f" {number}") for number in range(6)], ignore_index=True)
    odd = Column("odd", "what\nhappened")
    rows = many.assign(odd=r"a_b & 5 % of #1 {x} \ $ ^ ~ <2 >3")
    return {"memory": memory, "times": times,
            "all": Table("all", "Table I. " + "A caption of many words. " * 20, [*times.columns, odd], rows, [*[c.key for c in times.columns], "odd"])}


def faults_of(text: str, folder) -> list[str]:
    """What LaTeX complains about."""
    if not shutil.which("pdflatex"):
        pytest.skip("pdflatex is missing (tools/setup texlive-latex-recommended): tables are not set")
    (folder / "table.tex").write_text(text)
    (folder / "document.tex").write_text(DOCUMENT)
    done = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "document"], cwd=folder, capture_output=True, text=True,
                          check=False, timeout=120)
    told = [line for line in done.stdout.splitlines() if line.startswith("!") or any(fault in line for fault in FAULTS)]
    return told if done.returncode == 0 else told or ["no document"]


@pytest.mark.parametrize("name", ["memory", "times", "all"])
def test_a_table_fits_a_page_of_an_article(name, tables, tmp_path):
    assert faults_of(table_formats.as_latex(tables[name]), tmp_path) == []


def test_a_table_that_does_not_fit_is_seen(tables, tmp_path, monkeypatch):
    monkeypatch.setattr(table_formats, "LATEX_WIDTH", 900.0)
    monkeypatch.setattr(table_formats, "LATEX_HEIGHT", 900.0)
    told = "\n".join(faults_of(table_formats.as_latex(tables["all"]), tmp_path))
    assert "Overfull" in told and "Float too large" in told


def test_signs_of_latex_stand_as_they_are_and_minus_is_a_minus():
    rows = pd.DataFrame({"muscle": ["a_b"], "name": [r"5 % {of} \x^2"], "change": [-0.25]})
    text = table_formats.as_latex(Table("odd", "Table IV. A caption.", [Column("name", "name"), Column("change", "change", 2)], rows, ["name", "change"]))
    assert r"5 \% \{of\} \textbackslash{}x\^{}2 & $-$0.25 \\" in text and r"\emph{a b}" in text
    assert r"\caption{A caption.}" in text and text.startswith("% Needs \\usepackage{booktabs}")


def test_every_row_stands_once_in_parts_that_a_page_holds(tables):
    """Each part with the heading of the muscle that it begins with."""
    table = tables["all"]
    pages = table_formats._latex_pages(table)
    assert pd.concat(pages).equals(table.rows) and len(pages) > 1
    parts = table_formats.as_latex(table).split("\\begin{table*}")[1:]
    assert all("\\midrule\n\\multicolumn" in part for part in parts)
