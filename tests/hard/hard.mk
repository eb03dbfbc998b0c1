# tests/hard/hard.mk - the hard cases: `make hard-cases` and `make soak`.
#
#   make hard-cases                          all of them at all frame steps; writes docs/stability.md
#   make hard-cases CASE=B06 STEP=1/60       some of them: their table is build/hard/report.md, the document stays as it is
#   make hard-cases FILM=1                   with a picture of the end of each run in build/hard/pictures/
#   make hard-cases LIMIT=20                 CPU seconds that one run may take (60)
#   make soak [SEED=1] [COUNT=1000] [SOAK_SECONDS=20]   random worlds; a seed that fails is shrunk and printed as a script;
#                                            then [MACHINES=200] worlds of bridges, carts, figures, heaps, ... and [ROOMS=200]
#                                            of laid tables, stones, bottles, ladders, ... for 6 s each, then the properties of DIGs and messages on 1000 worlds each, 10,000 piles that are
#                                            knocked, and a room that is stirred for 100,000 frames

#   make hard-peers [CASE=B06] [STEP=1/60] [PEER=ode] [PEER_LIMIT=20]     the same cases on Bullet, ODE and MuJoCo, where installed;
#                                            part of hard-cases, which fills their columns (PEER=none leaves them out)
#   make hard-report                         the tables again from the rows of the last runs
#
# The peers are Debian's packages (.ci/packages.txt, group accuracy) and are built for this only; one that is not installed is left out.

.PHONY: hard-cases hard-peers hard-report soak
SEED    ?= 1
COUNT   ?= 1000
SOAK_SECONDS ?= 20
MACHINES ?= 200
ROOMS ?= 200

hard-cases: all                                 ## the hard cases at every frame step, other engines beside; writes docs/stability.md
	@BUILD=$(BUILD) LIMIT=$(LIMIT) FILM=$(FILM) sh tests/hard/measure.sh "$(CASE)" "$(STEP)"
	@$(if $(filter none,$(PEER)),,$(MAKE) hard-peers)
	@lua5.4 tests/hard/report.lua $(BUILD)/hard $(if $(CASE),$(BUILD)/hard/report.md,docs/stability.md)

hard-report:
	@lua5.4 tests/hard/report.lua $(BUILD)/hard $(if $(CASE),$(BUILD)/hard/report.md,docs/stability.md)

# ---- the same cases on other engines: a Lua module for each ----
hard_dir      := $(BUILD)/hard/peers
hard_flags    := -O2 -g -fPIC -ffp-contract=off -D_GNU_SOURCE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror
hard_headers  := tests/hard/peers/peer.h tests/bench/scene.h
ifneq ($(filter hard-peers,$(MAKECMDGOALS)),)
hard_has       = $(shell pkg-config --exists $(1) 2>/dev/null && echo yes)
hard_engines  := $(if $(call hard_has,bullet),bullet) $(if $(call hard_has,ode),ode) $(if $(wildcard /usr/include/mujoco/mujoco.h),mujoco)
endif
hard_modules   = $(patsubst %,$(hard_dir)/peer_%.so,$(strip $(hard_engines)))

hard-peers: all $(hard_modules)                 ## the hard cases on Bullet, ODE and MuJoCo, where they are installed
	@for e in $(hard_engines); do lua5.4 tests/hard/peers/selftest.lua $(hard_dir) $$e || exit 1; done
	@BUILD='$(BUILD)' LIMIT='$(PEER_LIMIT)' PEER='$(PEER)' sh tests/hard/peers/measure.sh "$(CASE)" "$(STEP)"

$(hard_dir)/obj/module-%.o: tests/hard/peers/module.c $(hard_headers)
	@mkdir -p $(@D)
	$(call say,CC,$@)$(CC) -std=c17 $(hard_flags) $(LUA_CFLAGS) -DPEER_OPEN=luaopen_peer_$* -c -o $@ $<
$(hard_dir)/obj/%.o: tests/hard/peers/%.c $(hard_headers)
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) -std=c17 $(hard_flags) -c -o $@ $<
$(hard_dir)/obj/bench-%.o: tests/bench/%.c $(hard_headers)
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) -std=c17 $(hard_flags) -c -o $@ $<
$(hard_dir)/obj/%.o: tests/hard/peers/%.cpp $(hard_headers)
	@mkdir -p $(@D)
	$(call say,CXX,$<)$(CXX) -std=c++17 $(hard_flags) $(call system,$(shell pkg-config --cflags bullet)) -c -o $@ $<

hard_libs-bullet = $(shell pkg-config --libs bullet)
hard_libs-ode    = $(shell pkg-config --libs ode)
hard_libs-mujoco = -lmujoco
$(hard_dir)/peer_%.so: $(hard_dir)/obj/%.o $(hard_dir)/obj/module-%.o $(patsubst %,$(hard_dir)/obj/%.o,solids bench-check bench-scene)
	$(call say,LINK,$@)$(CXX) -shared -o $@ $^ $(hard_libs-$*) -lm
.SECONDARY: $(patsubst %,$(hard_dir)/obj/%.o,solids bench-check bench-scene $(foreach e,bullet ode mujoco,$(e) module-$(e)))

soak: all                                       ## 1000 random worlds for 20 s each, 200 of machines, 200 rooms
	@BUILD=$(BUILD) sh tests/hard/soak.sh $(SEED) $(COUNT) $(SOAK_SECONDS)
	@BUILD=$(BUILD) sh tests/hard/soak.sh $(SEED) $(MACHINES) 6 machines
	@BUILD=$(BUILD) sh tests/hard/soak.sh $(SEED) $(ROOMS) 6 rooms
	@$(MAKE) unit T=test_properties && DIGBOX_FULL=1 $(BUILD)/unit/test_properties
	@$(MAKE) $(BUILD)/unit/test_random_stacks && DIGBOX_FULL=1 $(BUILD)/unit/test_random_stacks
