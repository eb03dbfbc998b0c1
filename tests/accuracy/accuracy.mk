# tests/accuracy/accuracy.mk - `make accuracy`: the work-precision report, digbox beside other engines.
#
#   make accuracy                           everything; writes docs/accuracy.md and docs/accuracy/*.svg
#   make accuracy SCENE=A07 ENGINE=digbox   one scene, one engine; the report goes to build/accuracy/ only
#   make accuracy REPORT=only               the report again, from the figures of the last run
#
# The peers are Debian's packages and are built for this only; one that is not installed is left out.

.PHONY: accuracy accuracy-run
accuracy_dir := $(BUILD)/accuracy
peer_common  := tests/peers/suite.c tests/peers/cases.c tests/peers/exact.c
peer_flags   := -O2 -g -ffp-contract=off -D_GNU_SOURCE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror
peer_headers := $(wildcard tests/peers/*.h)
CXX          ?= g++

# One package of pkg-config each, except MuJoCo, which has none.
ifneq ($(filter accuracy accuracy-run,$(MAKECMDGOALS)),)
has_package   = $(shell pkg-config --exists $(1) 2>/dev/null && echo yes)
peers        := $(if $(call has_package,bullet),bullet) $(if $(call has_package,bullet-float64),bullet64) \
                $(if $(call has_package,ode),ode) $(if $(wildcard /usr/include/mujoco/mujoco.h),mujoco)
endif
peer_programs = $(patsubst %,$(accuracy_dir)/peer-%,$(strip $(peers)))

accuracy:                                       ## error against CPU time, with other engines beside; SCENE=A07 ENGINE=digbox choose
	@sh .ci/install.sh build accuracy || echo "accuracy: goes on with what is installed" >&2
	@$(MAKE) all
	@$(MAKE) accuracy-run

accuracy-run: $(peer_programs)
	@$(if $(filter only,$(REPORT)),,BUILD=$(BUILD) sh tests/accuracy/measure.sh "$(SCENE)" "$(ENGINE)")
	@BUILD=$(BUILD) lua5.4 tests/accuracy/report.lua $(if $(SCENE)$(ENGINE),$(accuracy_dir),docs)

$(accuracy_dir)/obj/%.o: tests/peers/%.c $(peer_headers)
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) -std=c17 $(peer_flags) -c -o $@ $<
$(accuracy_dir)/obj/bullet.o: tests/peers/bullet.cpp $(peer_headers)
	@mkdir -p $(@D)
	$(call say,CXX,$<)$(CXX) -std=c++17 $(peer_flags) $(call system,$(shell pkg-config --cflags bullet)) -c -o $@ $<
$(accuracy_dir)/obj/bullet64.o: tests/peers/bullet.cpp $(peer_headers)
	@mkdir -p $(@D)
	$(call say,CXX,$<)$(CXX) -std=c++17 $(peer_flags) -isystem /usr/include/bullet $(shell pkg-config --cflags bullet-float64) -c -o $@ $<

peer_libs-ode      = $(shell pkg-config --libs ode)
peer_libs-bullet   = $(shell pkg-config --libs bullet)
peer_libs-bullet64 = $(shell pkg-config --libs bullet-float64)
peer_libs-mujoco   = -lmujoco
$(accuracy_dir)/peer-%: $(accuracy_dir)/obj/%.o $(patsubst tests/peers/%.c,$(accuracy_dir)/obj/%.o,$(peer_common))
	$(call say,LINK,$@)$(CXX) -o $@ $^ $(peer_libs-$*) -lm
.SECONDARY: $(patsubst %,$(accuracy_dir)/obj/%.o,suite cases exact ode bullet bullet64 mujoco)
