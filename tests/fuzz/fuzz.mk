# tests/fuzz/fuzz.mk - `make fuzz`: clang's libFuzzer on each target of tests/fuzz/, under AddressSanitizer and UBSan.
#
#   make fuzz                    SECONDS=60 of CPU time for each target (RUNS=N instead: that many inputs, from fixed seeds)
#   make fuzz RUNS=short         some seconds each, in .ci/run
#   make fuzz T=replay           one target
# What was learnt is kept in build/fuzz/NAME/ and begun with the next time; inputs that broke something lie in build/fuzz/.
# tests/unit/test_fuzz.c runs the same targets for seconds in every `make test`, with any compiler.

SECONDS ?= 60
RUNS    ?=
fuzz_src := $(wildcard tests/fuzz/target_*.c)
fuzz_all := $(patsubst tests/fuzz/target_%.c,$(BUILD)/fuzz_%,$(fuzz_src))

# Loops without branches over numbers: coverage learns nothing there, and clang takes 60 to 90 s for it and UBSan, and 3 s without. gcc's
# sanitizers are on it in `make asan`.
build/fuzz/obj/engine/crowd/wide.o build/fuzz/obj/engine/crowd/wide16.o: extra = -Wno-psabi -fno-sanitize=undefined,fuzzer-no-link

.PHONY: fuzz fuzz-programs

fuzz:                                           ## libFuzzer on scripts, saved worlds, replays and meshes; SECONDS=60 each
	@sh .ci/install.sh build fuzz
	@$(MAKE) BUILD=build/fuzz CC=clang RENDER=0 SANITIZE=1 CFLAGS='-g -fsanitize=fuzzer-no-link' fuzz-programs
	@T='$(T)' SECONDS_EACH='$(SECONDS)' RUNS='$(RUNS)' bash tests/fuzz/fuzz.sh $(fuzz_src)

fuzz-programs: $(fuzz_all)

$(BUILD)/fuzz_%: tests/fuzz/target_%.c tests/fuzz/main.c tests/fuzz/state.c tests/fuzz/fuzz.h tests/fuzz/state.h $(core_a) $(lua_a)
	$(call say,CC,$<)$(CC) $(BASE) $(LUA_CFLAGS) -Itests -I. -Ilua -fsanitize=fuzzer -DFUZZ_TARGET=fuzz_$* tests/fuzz/main.c \
	    tests/fuzz/state.c $< -o $@ $(lua_a) $(core_a) -Wl,--as-needed $(LUA_LIBS) $(EDIT_LIBS) $(CORE_LIBS)
