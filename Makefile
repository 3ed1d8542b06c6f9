# make        set up, and run the quick study
# make resume the same after Snakemake was killed
# make test   set up, and pass the tests, but for those of the whole smoke study
# make study  pass those
PYTHON ?= python3

quick: .venv/ready
	.venv/bin/snakemake --cores 2

resume: .venv/ready
	.venv/bin/snakemake --cores 2 $(OPTIONS) --unlock
	.venv/bin/snakemake --cores 2 $(OPTIONS)

test: .venv/ready
	.venv/bin/python -m pytest -n 3 --dist loadfile --no-loadscope-reorder -m "not study"

study: .venv/ready
	.venv/bin/python -m pytest -m study

.venv/ready: requirements.txt pyproject.toml
	$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11) and 'Python 3.11 or newer is needed: make PYTHON=python3.11')"
	$(PYTHON) -m venv .venv
	.venv/bin/python -m pip install --quiet --disable-pip-version-check -r requirements.txt
	.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps -e .
	.venv/bin/python -m compileall -q src paper_figures
	touch $@

.PHONY: quick resume test study
