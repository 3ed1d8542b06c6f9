# make        set up, and run the quick study
# make resume the same after Snakemake was killed
# make test   set up, and pass the tests: each promise, with a few of its cases; what steps beside
#             the plain reference is passed without the compiler
# make look   the quick study's report in Debian's chromium, wide and narrow, light and dark: checks, and
#             four pictures in results/look
# make docs   the site, into docs/_build/html: its tutorials are executed, and their numbers checked
# make thorough  pass the others: all cases, long statistics, the whole smoke study
PYTHON ?= python3
TESTS = .venv/bin/python -m pytest -n 3 --dist loadfile --no-loadscope-reorder

quick: .venv/ready
	.venv/bin/snakemake --cores 2

resume: .venv/ready
	.venv/bin/snakemake --cores 2 $(OPTIONS) --unlock
	.venv/bin/snakemake --cores 2 $(OPTIONS)

test: .venv/ready
	NUMBA_DISABLE_JIT=1 $(TESTS) -m plain tests/engine
	$(TESTS) -m "not thorough"

thorough: .venv/ready
	$(TESTS) -m thorough

docs: .venv/ready
	sed -n 's/^#docs //p' requirements.txt > .venv/docs.txt
	.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-compile -r .venv/docs.txt
	.venv/bin/python -m sphinx -qW -j 2 docs docs/_build/html

look: .venv/ready
	.venv/bin/python -m pip install --quiet $$(sed -n 's/^# `make look` installs: //p' requirements.txt)
	.venv/bin/python docs/look.py results/quick/report.html

# Without bytecode, which Python makes of what is imported: of all packages it takes 20 s of 60.
.venv/ready: requirements.txt pyproject.toml
	$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11) and 'Python 3.11 or newer is needed: make PYTHON=python3.11')"
	$(PYTHON) -m venv .venv
	.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-compile -r requirements.txt
	.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps -e .
	.venv/bin/python -m compileall -q src paper_figures
	touch $@

.PHONY: quick resume test docs look thorough
