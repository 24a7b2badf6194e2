# The everyday commands; `make help` lists them. The C++ build itself is CMakeLists.txt.
BUILD := build/release
JOBS ?= $(shell nproc)
FUZZ_SECONDS ?= 60
FUZZ_TARGETS := script arms calibration profile urdf page recording motion link rcss unitree
ARGS ?=

export PATH := $(CURDIR)/.venv/bin:$(PATH)

# The page in web/ (TypeScript), built into web/dist; nothing to do while there is none.
PAGE := $(if $(wildcard web/package.json),web/dist/index.html)
PAGE_SOURCES := $(if $(PAGE),$(shell find web \( -name node_modules -o -name dist \) -prune -o -type f -print))
has_script = $(shell grep -s '"$(1)" *:' web/package.json)
PYTHON_TESTS := $(shell find tests/python -name 'test_*.py' 2>/dev/null)

# CMake remembers absolute paths: after this checkout was moved or copied, a build folder would go on building the
# sources at the old place. `moved` is not empty for such a folder; `forget` removes it.
moved = $(shell there=$$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' $(1)/CMakeCache.txt 2>/dev/null); \
  [ -z "$$there" ] || [ "$$there" -ef . ] || echo yes)
forget = $(if $(call moved,$(1)),@echo "$(1) was configured in another folder: making it anew" && rm -rf $(1))

.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help run build page test test-fast test-cpp test-page test-python test-wheel wheel sanitize sanitize-fast sanitize-threads fuzz ci-clang bench bench-placo format lint robots rcss setup setup-wheel setup-test setup-dev clean anew

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

run: $(BUILD)/build.ninja $(PAGE) ## set up, build, and drive the robot (ARGS="..." are handed on)
	@cmake --build $(BUILD) --target baton_cli
	@$(BUILD)/baton drive $(ARGS)

build: $(BUILD)/build.ninja $(PAGE) ## build everything: library, program, tests, benches, page
	@cmake --build $(BUILD)

page: $(PAGE) ## build the page only

test: setup-test build test-cpp test-page test-python test-wheel ## build and run every test

test-fast: setup-test $(BUILD)/build.ninja ## run the C++ tests that take less than a minute together
	@cmake --build $(BUILD) --target baton_tests
	ctest --test-dir $(BUILD) -j$(JOBS) --output-on-failure --no-tests=error -LE slow

test-cpp:
	ctest --test-dir $(BUILD) -j$(JOBS) --output-on-failure --no-tests=error

test-page:
ifneq ($(call has_script,test),)
	cd web && npm test --silent
endif
ifneq ($(call has_script,test:browser),)
	cd web && npm run --silent test:browser
endif

test-python: rcss
ifneq ($(PYTHON_TESTS),)
	.venv/bin/pytest -q tests/python tests/robots
endif

# In an environment that has the package as its users get it, with the pinned versions of what it needs.
test-wheel: wheel
	.venv/bin/python -m venv --clear build/wheel-env
	build/wheel-env/bin/pip install -q --disable-pip-version-check -c scripts/requirements.txt dist/baton-*.whl pytest
	build/wheel-env/bin/pytest -q -p no:cacheprovider tests/wheel

sanitize: setup-test ## build with the sanitizers and run the C++ tests
	$(call forget,build/sanitize)
	cmake --preset sanitize
	cmake --build --preset sanitize
	ctest --preset sanitize -j$(JOBS)

# Of the tests that are run for both bipeds, those with the second find nothing more here, and take as long.
sanitize-fast: setup-test ## the same for the tests of test-fast, with mighty alone
	$(call forget,build/sanitize)
	cmake --preset sanitize
	cmake --build --preset sanitize --target baton_tests
	ctest --preset sanitize -j$(JOBS) -LE slow -E /scaled

sanitize-threads: setup-test ## build with the thread sanitizer and run the tests of what has threads
	$(call forget,build/thread)
	cmake --preset thread
	cmake --build --preset thread --target baton_tests
	ctest --preset thread -j$(JOBS) -E /scaled

# What is found new goes to build/fuzz/corpus, for the next run; an input that is a finding to build/fuzz/found-*.
fuzz: setup-dev ## fuzz the readers of files and messages (FUZZ_SECONDS=60 each; needs clang)
	$(call forget,build/fuzz)
	cmake --preset fuzz
	cmake --build --preset fuzz
	@mkdir -p $(FUZZ_TARGETS:%=build/fuzz/corpus/%)
	@echo "fuzzing $(FUZZ_TARGETS), each for $(FUZZ_SECONDS) s"
	@printf '%s\n' $(FUZZ_TARGETS) | xargs -P $(JOBS) -I TARGET sh -c 'build/fuzz/fuzz_TARGET -seed=1 -timeout=10 \
	  -rss_limit_mb=2048 -max_total_time=$(FUZZ_SECONDS) -print_final_stats=1 -artifact_prefix=build/fuzz/found-TARGET- \
	  build/fuzz/corpus/TARGET tests/fuzz/corpus/TARGET >build/fuzz/TARGET.log 2>&1 || \
	  { tail -n 60 build/fuzz/TARGET.log; exit 1; }; \
	  echo "TARGET: $$(sed -n "s/^stat::number_of_executed_units: *//p" build/fuzz/TARGET.log) inputs"'

ci-clang: setup-dev ## build with clang, warnings as errors
	$(call forget,build/clang)
	cmake --preset clang
	cmake --build --preset clang

bench: build ## CPU times; durations against their lower bound; a baseline; latency; each robot (about ten minutes)
	$(BUILD)/baton_bench $(ARGS)

bench-placo: build ## inverse kinematics beside that of placo (PyPI), on the same targets (ARGS="--robot talos")
	.venv/bin/python -m venv build/placo-env
	build/placo-env/bin/pip install -q --disable-pip-version-check -r scripts/requirements-placo.txt
	build/placo-env/bin/python bench/ik_placo.py --bench $(BUILD)/baton_bench $(ARGS)

format: setup-dev ## format all C++ sources
	scripts/lint --format

lint: setup-dev $(BUILD)/build.ninja ## check the format, and run clang-tidy on what changed (ARGS=--all: on everything)
	scripts/lint $(ARGS)

# The libraries of Debian that the module is linked with go into the wheel; MuJoCo and eiquadprog have wheels of their own.
wheel: setup-wheel ## build the Python package: dist/baton-….whl
	$(call forget,build/wheel)
	@mkdir -p build/wheels dist
	@rm -f build/wheels/baton-*.whl dist/baton-*.whl
	.venv/bin/pip wheel . --no-build-isolation --no-deps --disable-pip-version-check -q -w build/wheels
	.venv/bin/auditwheel repair --exclude 'libmujoco.so.*' --exclude libeiquadprog.so -w dist build/wheels/baton-*.whl
	@ls dist/baton-*.whl

robots: setup ## fetch the models of the robots that are shipped as profiles (NAMES="g1 t1": those alone)
	@scripts/fetch_robots $(NAMES)

rcss: setup ## install the RoboCup 3D simulator that `baton bridge rcss` drives robots in, and fetch its robots
	@scripts/setup_rcss

setup: ## install what is missing
	@scripts/setup

setup-wheel:
	@scripts/setup --wheel

setup-test:
	@scripts/setup --test

setup-dev:
	@scripts/setup --dev

clean: ## remove what was built (not what was installed)
	rm -rf build dist web/dist

$(BUILD)/build.ninja: $(if $(call moved,$(BUILD)),anew) | setup
	$(call forget,$(BUILD))
	cmake --preset release

anew:

web/dist/index.html: $(PAGE_SOURCES) | setup
	cd web && npm run --silent build
	@touch $@
