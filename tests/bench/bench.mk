# tests/bench/bench.mk - `make bench`: time per step of digbox beside other engines on the same large scenes.
#
#   make bench                                   the scenes of the published tables; writes build/bench.json and prints a table
#   make bench SCENE=towers ENGINE=digbox N=200  one scene, one engine, one size
#   make bench SCENE=digs                        membership and messages: 5000 DIGs of 50, against a flat union-find
#   make bench SCENE=render                      frames a second: time per phase, one and two processes, error of the edges
#   make bench SCENE=looks                       one scene as we draw it and as MuJoCo's renderer does: build/bench/looks/*.png
#   make bench SCENE=page                        what it takes to open the page of a replay of 10 s, in headless Chromium (after make viewer)
#   make bench SCENE=replay                      what --replay costs, in instructions: 200 and 1000 boxes; valgrind counts (minutes)
#   make bench SCENE=questions                   can this door be opened? in steps of its DIG, alone and among a hundred others
#   make bench FULL=1                            also 16,000 spheres, 100,000 bodies in a room, 1,000,000 fixed boxes
#   make bench LIMIT=60 TOTAL=1200 REPEATS=5     seconds for one run, for all of them, and how often
#   make bench REPORT=only                       the table again, from the rows of the last run
#
#   make scaling                                 what a step costs per body, pair, contact and joint; writes docs/scaling.md
#
# The peers are Debian's packages and are built for this only; one that is not installed is left out.

.PHONY: bench bench-run scaling
bench_dir     := $(BUILD)/bench
bench_common  := tests/bench/run.c tests/bench/scene.c tests/bench/check.c
bench_flags   := -O2 -g -ffp-contract=off -D_GNU_SOURCE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror
bench_headers := $(wildcard tests/bench/*.h) engine/digbox.h
CXX           ?= g++

ifneq ($(filter bench bench-run,$(MAKECMDGOALS)),)
bench_has      = $(shell pkg-config --exists $(1) 2>/dev/null && echo yes)
bench_engines := digbox $(if $(call bench_has,bullet),bullet) $(if $(call bench_has,ode),ode) \
                 $(if $(wildcard /usr/include/mujoco/mujoco.h),mujoco)
endif
bench_programs = $(patsubst %,$(bench_dir)/bench-%,$(strip $(bench_engines)))

bench:                                          ## time per step against other engines; SCENE=towers ENGINE=digbox N=200 FULL=1 choose
	@sh .ci/install.sh build bench || echo "bench: goes on with what is installed" >&2
	@$(MAKE) bench-run

ifeq ($(SCENE),digs)
bench-run: $(bench_dir)/digs
	@$(bench_dir)/digs
else ifeq ($(SCENE),render)
bench-run: $(bench_dir)/render
	@$(bench_dir)/render $(or $(N),300) $(bench_dir)/frames
else ifeq ($(SCENE),looks)
bench-run: $(bench_dir)/looks.run all
	@mkdir -p $(bench_dir)/looks && rm -f $(bench_dir)/looks/*
	@$(program) run -q tests/bench/looks.lua -o $(bench_dir)/looks >$(bench_dir)/looks/scene.txt
	@$(bench_dir)/looks.run $(bench_dir)/looks/mujoco.png <$(bench_dir)/looks/scene.txt && ls $(bench_dir)/looks/*.png
else ifeq ($(SCENE),page)
bench-run: all
	@mkdir -p $(bench_dir)/page
	@$(program) run -q tests/bench/tumble.lua --set seconds=10 -o $(bench_dir)/page --force --replay $(bench_dir)/page/tumble.replay
	@$(program) view $(bench_dir)/page/tumble.replay -o $(bench_dir)/page/tumble.html
	@CHROMIUM=$(or $(shell command -v chromium),chromium) NODE_MODULES=build/viewer/node_modules \
	    node tests/view/open.mjs $(bench_dir)/page/tumble.html $(or $(REPEATS),5)
else ifeq ($(SCENE),replay)
bench-run: all
	@sh tests/bench/replay.sh $(program) $(bench_dir)/replay
else ifeq ($(SCENE),questions)
bench-run: $(bench_dir)/questions
	@$(bench_dir)/questions
else
bench-run: $(bench_programs) $(bench_dir)/selftest
	@$(bench_dir)/selftest
	@$(if $(filter only,$(REPORT)),,BUILD='$(BUILD)' SCENE='$(SCENE)' ENGINE='$(ENGINE)' N='$(N)' FULL='$(FULL)' LIMIT='$(LIMIT)' \
	    TOTAL='$(TOTAL)' REPEATS='$(REPEATS)' PLAN='$(PLAN)' sh tests/bench/measure.sh)
	@lua5.4 tests/bench/report.lua $(bench_dir)/rows.lua $(BUILD)/bench.json
endif

$(bench_dir)/obj/%.o: tests/bench/%.c $(bench_headers)
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) -std=c17 -Iengine $(bench_flags) -c -o $@ $<
$(bench_dir)/obj/%.o: tests/bench/%.cpp $(bench_headers)
	@mkdir -p $(@D)
	$(call say,CXX,$<)$(CXX) -std=c++17 $(bench_flags) $(call system,$(shell pkg-config --cflags bullet)) -c -o $@ $<

bench_libs-digbox = $(core_a) -pthread $(CORE_LIBS)
bench_libs-bullet = $(shell pkg-config --libs bullet)
bench_libs-ode    = $(shell pkg-config --libs ode)
bench_libs-mujoco = -lmujoco
$(bench_dir)/selftest: $(patsubst %,$(bench_dir)/obj/%.o,selftest scene check)
	$(call say,LINK,$@)$(CC) -o $@ $^ -lm
$(bench_dir)/digs $(bench_dir)/questions: $(bench_dir)/%: $(bench_dir)/obj/%.o $(core_a)
	$(call say,LINK,$@)$(CC) -o $@ $^ -pthread $(CORE_LIBS)
$(bench_dir)/render: $(bench_dir)/obj/render.o $(render_a) $(core_a)
	$(call say,LINK,$@)$(CC) -o $@ $^ -pthread $(RENDER_LIBS) $(CORE_LIBS)
$(bench_dir)/looks.run: $(bench_dir)/obj/looks.o
	$(call say,LINK,$@)$(CC) -o $@ $^ -lmujoco -lOSMesa -lpng -lm
$(bench_dir)/bench-digbox: $(core_a)
$(bench_dir)/bench-%: $(bench_dir)/obj/%.o $(patsubst tests/bench/%.c,$(bench_dir)/obj/%.o,$(bench_common))
	$(call say,LINK,$@)$(if $(filter digbox,$*),$(CC),$(CXX)) -o $@ $(filter %.o,$^) $(bench_libs-$*) -lm
.SECONDARY: $(patsubst %,$(bench_dir)/obj/%.o,run scene check selftest digs questions looks digbox bullet ode mujoco)

scaling: all                                    ## what a step costs as worlds grow; writes docs/scaling.md
	@sh tests/bench/scaling.sh $(BUILD)/digbox docs/scaling.md
