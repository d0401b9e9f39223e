# make lab    set up, compare all built-in scenes by the methods, write and name the report
# make test   set up, then lint, types, import rules, tests (with the JIT and without)
# make proof  the long run: every scene, many sizes (MESHES=DIR adds real meshes), and what the README shows
# make docs   the API reference: reports/api/index.html
# make samples  write the report, the course of lessons and the gallery that are kept under reports/
# make clean  remove the environment and generated reports

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
REPORT ?= reports/lab.html
SIZE ?= 512x512
SHOWN := solids cyclic engineering teapot
TURNING := solids cyclic teapot
SAMPLED := exact backface painter scanline scanline-d16 zbuffer raycast opengl
ROOT := $(shell [ "$$(id -u)" = 0 ] || echo "sudo -n")
PIP := $(BIN)/python -m pip install -q --disable-pip-version-check --no-compile
USED := import hsr.cli.compare, hsr.pages.report, matplotlib.colors, rich.progress, skimage.measure, skimage.morphology
APT := $(ROOT) env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0

# What is imported is compiled once and kept, also where the environment says otherwise.
export PYTHONDONTWRITEBYTECODE :=

# Install Debian packages where that is possible without asking; say what to type where it is not.
install = $(APT) update >/dev/null 2>&1 && $(APT) install -y --no-install-recommends $(1) >/dev/null 2>&1 \
	|| echo "not installed: $(1); for $(2) run: apt-get install -y --no-install-recommends $(1)"

.PHONY: lab test proof docs samples clean opengl browser

lab: $(VENV)/lab.stamp opengl
	@$(BIN)/hsr compare scenes/*.toml --size $(SIZE) -o $(REPORT)

# Idle threads of one process shall not take the time of the other's, and a file's kernels are compiled by one.
test: export OMP_WAIT_POLICY := passive
test: $(VENV)/test.stamp opengl browser
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/pytest -n 2 --dist loadfile
	NUMBA_DISABLE_JIT=1 $(BIN)/pytest -n 2 --dist loadfile tests/kernels tests/algorithms tests/certify tests/exact tests/models tests/difference


proof: $(VENV)/test.stamp opengl
	$(BIN)/python -m tests.proof $(if $(MESHES),--meshes $(MESHES)) -o reports/proof.md
	$(BIN)/python -m tests.proof_readme

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "Python 3.11 or newer is needed; name one with: make PYTHON=python3.12 lab"; exit 1; }
	@$(PYTHON) -m venv $(VENV) 2>/dev/null \
		|| { $(call install,python3-venv,the environment); $(PYTHON) -m venv $(VENV); }

# Pip before 25 takes twice as long. The first import compiles what is used of the packages, a quarter of them.
$(VENV)/lab.stamp: pyproject.toml | $(VENV)/bin/python
	@echo "installing the packages of pyproject.toml into $(VENV) (once, about a minute)"
	@$(PIP) 'pip>=25'
	@$(PIP) -e '.[embree]' || { $(PIP) -e . && echo "no Embree for this platform: its columns will say so"; }
	@$(BIN)/python -c '$(USED)'
	@touch $@

$(VENV)/test.stamp: $(VENV)/lab.stamp
	@$(PIP) -e '.[dev]'
	@touch $@

opengl:
	@ldconfig -p 2>/dev/null | grep -q libOSMesa || { command -v apt-get >/dev/null || exit 0; \
		echo "installing OSMesa, the OpenGL that needs no display"; \
		$(call install,libosmesa6,OpenGL); \
		ldconfig -p | grep -q -e libOSMesa -e libEGL_mesa \
		|| { $(call install,libegl1 libgl1 libgl1-mesa-dri,OpenGL); }; }

browser:
	@command -v chromium >/dev/null || { command -v apt-get >/dev/null || exit 0; \
		echo "installing Chromium, in which the report is tested"; \
		$(call install,chromium,the browser tests); }

docs: $(VENV)/test.stamp
	@$(BIN)/python docs/api.py reports/api

# What is kept shall not lead to what is not.
samples: $(VENV)/lab.stamp opengl
	rm -rf reports/lab.html reports/api
	$(BIN)/hsr compare scenes/cyclic.toml scenes/solids.toml --size 192 $(addprefix -a ,$(SAMPLED)) -o reports/sample.html
	$(BIN)/hsr lesson --all -o reports/lessons
	$(BIN)/hsr gallery $(addprefix scenes/,$(addsuffix .toml,$(SHOWN))) $(addprefix --turn ,$(TURNING)) -o reports/gallery

clean:
	rm -rf $(VENV) reports/lab.html reports/api
