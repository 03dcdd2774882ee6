# Everything starts here: `make run` opens the explorer, `make check` tests it in a minute or two, `make test` wholly.
# Each sets up what it needs in .venv, once; a stamp in there is touched last, so that a broken set-up is repeated.

PYTHON ?= python3
ARGS ?=

# The asserts of the tests are rewritten once and kept, not anew in each process of each run.
export PYTHONDONTWRITEBYTECODE :=

VENV := .venv
BIN := $(VENV)/bin
# Hashes are required and only wheels are taken, so that nothing is built and every file is pinned. A module is compiled
# when it is first imported: most never are imported, and to compile them all takes longer than to install them.
INSTALL := $(BIN)/python -m pip --disable-pip-version-check install --quiet --no-compile --require-hashes --only-binary :all:

.PHONY: help run check quick long test warm browser bench codes docs shown notebook gallery dist lint lock snapshots diagram image proxy release clean
.DELETE_ON_ERROR:

help:
	@echo "make run        open the explorer in the browser"
	@echo "make check      check style, run the tests that take less than a quarter of a second: a minute or two"
	@echo "make test       run all tests                 (ARGS='-k grazing' hands options to pytest)"
	@echo "make long       renew the list of tests that make check leaves out, on a machine that does nothing else"
	@echo "make docs       build the documentation, which the explorer serves under /docs: a minute or two"
	@echo "make shown      renew the outputs and figures that pages of the documentation show"
	@echo "make notebook   open docs/notebook.ipynb in JupyterLab, which it installs"
	@echo "make gallery    write reports of all scenes and published systems into build/gallery, to open without a server"
	@echo "make dist       build wheel and source archive into dist/, the documentation in them"
	@echo "make bench      measure costs and errors"
	@echo "make codes      run OpenSees, CalculiX and MuJoCo beside ours where they are installed, and write the table"
	@echo "make lint       check style and who may import whom"
	@echo "make snapshots  renew the pictures and data the tests compare with"
	@echo "make diagram    renew the results in assets/ that the page opens with"
	@echo "make lock       renew requirements/ from pyproject.toml"
	@echo "make image      build and run the container image without a container engine (Debian, root)"
	@echo "make proxy      try the reverse proxy of compose.yaml on this machine (needs nginx, curl; openssl)"
	@echo "make release    image, proxy and the wheel of dist/ where they can be tried, all examples, fuzz, faults, load, soak: two hours"
	@echo "make clean      remove .venv and the files of tools"

run: $(VENV)/run
	$(BIN)/vibroscope serve --show $(ARGS)

# The linters run beside the tests, in what these leave of two cores where they wait.
check: $(VENV)/test
	@$(MAKE) --no-print-directory --jobs 2 lint quick

# In two processes, without browser, and without the tests that tests/long.txt lists. One thread of linear algebra each:
# for matrices as small as these a second one costs more than it does.
quick: $(VENV)/test warm
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest --quick --numprocesses 2 --dist worksteal --ignore tests/ui $(ARGS)

long: $(VENV)/test warm
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest --write-long --numprocesses 2 --dist worksteal --ignore tests/ui $(ARGS)

# Likewise, file by file, those with a browser last in each process, since its driver leaves an event loop running. In
# three processes: a test with a browser waits for a third of its time.
test:
	@$(MAKE) --no-print-directory --jobs 2 warm browser
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest --numprocesses 3 --dist loadfile --no-loadscope-reorder $(ARGS)

# The kernels are compiled, so that no test waits for the compiler, while packages and browser of the tests are fetched.
warm: $(VENV)/run
	$(BIN)/vibroscope warm

browser: $(VENV)/test
	@browser=$$($(BIN)/python tools/browser.py) && echo "browser: $$browser"

bench: $(VENV)/test
	@for script in benchmarks/[!_]*.py; do echo "== $$script"; $(BIN)/python $$script || exit 1; done

# A warning is an error.
docs: $(VENV)/test warm
	rm -rf build/docs assets/site
	$(BIN)/sphinx-build --fail-on-warning --keep-going --quiet --doctree-dir build/docs/doctrees docs build/docs/site
	mv build/docs/site assets/

shown: $(VENV)/test
	$(BIN)/python docs/shown.py

notebook: $(VENV)/run requirements/notebook.txt
	$(INSTALL) -r requirements/notebook.txt
	$(BIN)/jupyter lab docs/notebook.ipynb $(ARGS)

gallery: $(VENV)/test
	$(BIN)/python docs/static_gallery.py $(ARGS)

dist: docs
	rm -rf dist
	$(BIN)/python -m build --no-isolation --outdir dist

# Needs CalculiX (Debian: calculix-ccx), and the libraries of OpenSees (Debian: libblas3 liblapack3).
codes: $(VENV)/test requirements/codes.txt
	$(INSTALL) -r requirements/codes.txt
	$(BIN)/python -m tools.codes --write

lint: $(VENV)/test
	$(BIN)/ruff check
	$(BIN)/ruff format --check --quiet
	$(BIN)/lint-imports
	$(BIN)/hadolint Dockerfile

snapshots: $(VENV)/test
	$(BIN)/pytest tests/ui/test_snapshots.py --renew-snapshots --all-examples $(ARGS)

diagram: $(VENV)/run
	$(BIN)/vibroscope diagram --write

image:
	tools/rehearse-image.sh

proxy: $(VENV)/run
	tools/rehearse-proxy.sh

# Each part that cannot be tried on this machine is reported at once and again at the end.
release: SHELL := bash
release: $(VENV)/test
	@mkdir -p build; set -o pipefail; { set -e; $(BIN)/hadolint Dockerfile; $(BIN)/python tools/images.py; \
	if [ "$$(id -u)" = 0 ] && command -v debootstrap >/dev/null && command -v buildah >/dev/null; then tools/rehearse-image.sh; else \
	  echo "NOT TRIED: the image, which needs root, debootstrap and buildah (Debian; make image installs the two)"; fi; \
	if command -v nginx >/dev/null && command -v curl >/dev/null; then tools/rehearse-proxy.sh; else \
	  echo "NOT TRIED: the proxy, which needs nginx and curl (Debian: apt install nginx-light curl)"; fi; \
	if [ -n "$$(ls dist/*.whl 2>/dev/null)" ]; then tools/try-dist.sh; else \
	  echo "NOT TRIED: the wheel, which make dist builds"; fi; \
	$(BIN)/pytest --all-examples --numprocesses 2 --dist worksteal --ignore tests/ui $(ARGS); \
	$(BIN)/pytest --all-examples $(addprefix tests/ui/test_,documentation.py sizes.py snapshots.py take_away.py) $(ARGS); \
	$(BIN)/pytest -m release -s -o faulthandler_timeout=1800 tests/release tests/engine tests/test_docs.py tests/ui/test_walk.py $(ARGS); \
	} 2>&1 | tee build/release.log; code=$$?; \
	echo; grep -E 'NOT (TRIED|PINNED)' build/release.log || echo "release: nothing was left out"; exit $$code

clean:
	rm -rf $(VENV) build dist assets/site *.egg-info .pytest_cache .ruff_cache .import_linter_cache .hypothesis tests/results
	find . -name __pycache__ -prune -exec rm -rf {} +

# --- set-up -----------------------------------------------------------------------------------------------------

$(VENV)/made:
	@command -v "$(PYTHON)" >/dev/null || \
	  { echo "No Python found: '$(PYTHON)' is no command. Name one: make run PYTHON=/path/to/python3.12"; exit 1; }
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Python 3.11 or newer is needed, '$(PYTHON)' is $$("$(PYTHON)" -V 2>&1). Name another: make run PYTHON=python3.12"; exit 1; }
	@"$(PYTHON)" -c 'import ensurepip, venv' 2>/dev/null || \
	  { echo "'$(PYTHON)' cannot make virtual environments. On Debian and Ubuntu: apt install python3-venv"; exit 1; }
	"$(PYTHON)" -m venv --clear $(VENV)
	@touch $@

$(VENV)/run: $(VENV)/made requirements/run.txt pyproject.toml setup.py
	$(INSTALL) -r requirements/run.txt
	$(BIN)/python -m pip --disable-pip-version-check install --quiet --no-deps --no-build-isolation --editable .
	@touch $@

$(VENV)/test: $(VENV)/run requirements/test.txt
	$(INSTALL) -r requirements/test.txt
	@touch $@

# --- locks ------------------------------------------------------------------------------------------------------

# One version of each package for all platforms and Pythons, so that all machines compute the same numbers.
# Versions in the old locks stay where they still fit; `make lock ARGS=--upgrade` takes the newest.
LOCK = UV_CUSTOM_COMPILE_COMMAND="make lock" build/lock/bin/uv pip compile pyproject.toml --quiet --universal \
  --python-version 3.11 --fork-strategy fewest --generate-hashes --no-emit-index-url --group build $(ARGS)

# Other codes stand apart: the project's own packages are not theirs, and their wheels are for Linux.
lock: build/lock/bin/uv
	$(LOCK) --output-file requirements/image.txt
	$(LOCK) --extra fit --constraint requirements/image.txt --output-file requirements/run.txt
	$(LOCK) --extra fit --extra cluster --group test --group lint --group docs --constraint requirements/run.txt --output-file requirements/test.txt
	$(LOCK) --group docs --constraint requirements/test.txt --output-file requirements/docs.txt
	$(LOCK) --extra notebook --constraint requirements/test.txt --output-file requirements/notebook.txt
	$(BIN)/python -c "import tomllib; print(*tomllib.load(open('pyproject.toml', 'rb'))['project']['optional-dependencies']['codes'], sep='\n')" \
	  | $(subst --universal,--python-platform linux,$(subst --group build,,$(subst pyproject.toml,-,$(LOCK)))) \
	  --constraint requirements/test.txt --output-file requirements/codes.txt

build/lock/bin/uv: $(VENV)/made
	$(BIN)/python -m venv --clear build/lock
	build/lock/bin/python -m pip --disable-pip-version-check install --quiet uv
