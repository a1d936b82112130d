# The way without a ROS installation: everything lives in .venv, made of wheels. On a ROS 2 host
# use rosdep and colcon instead (README.md).
SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
.NOTPARALLEL:
.DELETE_ON_ERROR:

VENV := $(CURDIR)/.venv
PYTHON ?=
# Exactly this release: a range would take the newest, with several GB of CUDA packages. Where the
# package index offers PyTorch's CPU builds too, as PIP_EXTRA_INDEX_URL can, those are preferred.
TORCH ?= torch==2.13.0
# Arguments for pytest or the demo: make test ARGS='test/core -x'
ARGS ?=

# A ROS installation that was sourced, or another environment, must not leak into this one.
unexport PYTHONPATH PYTHONHOME AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH
unexport RMW_IMPLEMENTATION _ROS_WHEELS_BOOTSTRAP_COMPLETE COLCON_DEFAULTS_FILE
# Without byte code each process needs half a minute to import PyTorch.
unexport PYTHONDONTWRITEBYTECODE
ifdef ROS_DISTRO
unexport LD_LIBRARY_PATH
endif
export VIRTUAL_ENV := $(VENV)
export PATH := $(VENV)/bin:$(PATH)
export PYTHON

# A moved clone needs a new environment: scripts in it hold absolute paths.
MADE := $(VENV)/.made-$(firstword $(shell pwd | cksum))
INSTALLED := $(VENV)/.installed
MESSAGES := $(VENV)/.messages
PACKAGE := $(VENV)/.package
REQUIREMENTS := requirements.txt requirements-ros.txt requirements-dev.txt constraints.txt
# Without MAKEFLAGS colcon waits for a low load average, which a busy machine never has.
COLCON := MAKEFLAGS=-j$(shell nproc) AMENT_PREFIX_PATH=$(VENV) colcon --log-base $(VENV)/colcon/log build \
  --build-base $(VENV)/colcon/build --install-base $(VENV) --merge-install \
  --event-handlers console_direct- console_cohesion- desktop_notification-
WEIGHTS := out/weights
EXECUTABLES := perception_node metric_node imitate_node panel_node play_bag relations

.PHONY: help venv build demo test lint types docs weights figures clean
help:  ## Shows this list
	@sed -nE 's/^([a-z]+):.*## (.*)/  make \1\t\2/p' Makefile | expand -t 18

venv: $(INSTALLED)  ## Makes .venv with every pinned dependency

build: $(PACKAGE)  ## Builds the interfaces and the package into .venv

demo: build  ## Replays bags/ to the three nodes, asks for an imitation; results in out/demo
	@python -m spatial_relations_ros.nodes.demo $(ARGS)

test: build  ## Runs all tests
	@python -m pytest $(ARGS)

lint: $(INSTALLED)  ## Checks style and format
	@ruff check .
	@ruff format --check .

types: $(PACKAGE)  ## Checks types
	@mypy

docs: $(PACKAGE)  ## Builds the documentation into out/docs; warnings are errors
	@sphinx-build --fail-on-warning --keep-going --quiet --doctree-dir out/doctrees docs out/docs
	@echo 'out/docs/index.html'

weights: $(WEIGHTS)/train/scenes.txt $(WEIGHTS)/calibration/scenes.txt  ## Trains the shipped weights from nothing (over an hour) into out/weights
	@OMP_NUM_THREADS=1 relations train $(WEIGHTS)/train --held-out $(WEIGHTS)/calibration \
	  --run-dir $(WEIGHTS)/run --out $(WEIGHTS)/default.safetensors $(ARGS)

figures: $(PACKAGE)  ## Draws the documentation's pictures anew
	@python docs/make_figures.py $(ARGS)

clean:  ## Removes everything that was made here, .venv too
	rm -rf .venv build install log out .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# A dataset's last file; what was begun and not finished is drawn anew.
$(WEIGHTS)/train/scenes.txt: | $(PACKAGE)
	@relations generate $(@D) --scenes 16000 --objects 776 --seed 1 --jobs $(shell nproc)

$(WEIGHTS)/calibration/scenes.txt: | $(PACKAGE)
	@relations generate $(@D) --scenes 1050 --objects 194 --seed 101 --jobs $(shell nproc)

$(MADE):
	@echo '[1/4] Checking the system and making .venv'
	@python=$$(.ci/find-python); .ci/check-system "$$python"; \
	  echo "      $$("$$python" --version) at $$python"; \
	  "$$python" -m venv --clear $(VENV)
	@touch $@

$(INSTALLED): $(MADE) $(REQUIREMENTS)
	@echo '[2/4] Installing pinned packages: some minutes and about 2 GB the first time'
	@pip install --no-compile -c constraints.txt '$(TORCH)'
	@pip install --no-compile -c constraints.txt -r requirements.txt -r requirements-ros.txt -r requirements-dev.txt
	@echo '      Importing everything once'
	@python -c 'import cv2, manifold3d, open3d, rclpy, roma, rosbags, scipy.spatial, torch, typer'
	@touch $@

$(MESSAGES): $(INSTALLED) $(shell find msg_defs compat -type f)
	@echo '[3/4] Building the interfaces: one to two minutes the first time'
	@$(COLCON) --base-paths msg_defs compat/tf2_msgs
	@touch $@

$(PACKAGE): $(MESSAGES) package.xml setup.py setup.cfg \
  $(shell find spatial_relations_ros config launch models resource msg_defs/msg -type f -not -name '*.pyc')
	@echo '[4/4] Building the package'
	@$(COLCON) --base-paths . --packages-select spatial_relations_ros
	@for name in $(EXECUTABLES); do \
	  ln -sf ../lib/spatial_relations_ros/$$name $(VENV)/bin/$$name; done
	@touch $@
