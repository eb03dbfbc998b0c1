# Makefile - builds digbox. `make help` lists what it can do.
#
# Nothing is registered here: sources, tests, worlds and Lua files are found by
# wildcard. Products go to build/, pictures to out/, and nowhere else.

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.SUFFIXES:

# One job per core, unless -j says otherwise.
ifeq ($(MAKELEVEL),0)
MAKEFLAGS += -j$(shell nproc 2>/dev/null || echo 2) --no-print-directory --no-builtin-rules
endif

# ---- options: make SANITIZE=1, DEBUG=1, RENDER=0, CC=clang, V=1, T=pattern ----
ifeq ($(origin CC),default)
CC := gcc
endif
SANITIZE ?= 0
DEBUG    ?= 0
RENDER   ?= 1
V        ?= 0
T        ?=
PREFIX   ?= /usr/local
export V T

# Each kind of build has its own folder, so that switching costs nothing.
variant := $(if $(filter 1,$(SANITIZE)),-sanitize)$(if $(filter 1,$(DEBUG)),-debug)
BUILD   ?= build$(patsubst -%,/%,$(variant)$(if $(filter 0,$(RENDER)),-norender))
# Without a renderer one file is compiled otherwise (tests/lint/floors.sh holds that): all other objects are those of the build with one.
OBJ     := $(if $(filter file,$(origin BUILD)),build$(patsubst -%,/%,$(variant)),$(BUILD))/obj

# ---- flags ----
# psabi: wide numbers are passed to inlined functions only.
WARNINGS := -Wno-psabi -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wstrict-prototypes -Wmissing-prototypes -Werror
# The same bits on every machine and at every -O: no fused multiply-add, no -ffast-math.
CFLAGS   ?= -O3 -g
BASE     := -std=c17 $(CFLAGS) -ffp-contract=off -fno-math-errno -pthread $(WARNINGS) -Iengine
# What uses wide registers must leave their upper halves empty when it calls what does not: on some machines each way costs 140 cycles. GCC
# forgets that where it knows which registers a function of the same file takes. Clang has no such option.
BASE     += $(if $(findstring clang,$(shell $(CC) --version)),,-fno-ipa-ra)
# The same objects make the program and digbox.so. What is hidden costs nothing for it: the same code as without -fPIC, by instruction.
BASE     += -fPIC -fvisibility=hidden
LINK     := $(CC) -pthread
ifeq ($(DEBUG),1)
BASE     += -O0 -DDIG_DEBUG
endif
ifeq ($(SANITIZE),1)
sanitize := -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
# -g1: lines for traces; all of -g takes a quarter of the compiler's time.
BASE     += -O1 -g1 -DDIG_DEBUG $(sanitize)
LINK     += $(sanitize)
# gcc's runtime inside of programs, where there is a static one, as clang has it anyway: calls of a shared one take a tenth of the time.
of_gcc      := $(if $(findstring clang,$(shell $(CC) --version)),,$(shell $(CC) -print-file-name=libasan.a))
static_asan := $(if $(findstring /,$(of_gcc)),-static-libasan -static-libubsan)
endif

# pkg-config where it knows, Debian's places where it does not. $(call flags,--cflags|--libs,package,fallback)
flags    = $(or $(shell pkg-config $(1) $(2) 2>/dev/null),$(3))
system   = $(patsubst -I%,-isystem %,$(1))
LUA_CFLAGS    := $(call system,$(call flags,--cflags,lua5.4,-I/usr/include/lua5.4))
RENDER_CFLAGS := $(call system,$(call flags,--cflags,freetype2 libpng,-I/usr/include/freetype2))
CORE_LIBS     := -lqhull_r -ldeflate -lcjson -lnettle -lm
# Line editing in `digbox repl`, where libedit is there.
edit_header   := $(wildcard /usr/include/editline/readline.h /usr/local/include/editline/readline.h)
EDIT_CFLAGS   := $(if $(edit_header),-DDIGBOX_EDIT)
EDIT_LIBS     := $(if $(edit_header),-ledit)
LUA_LIBS      := $(call flags,--libs,lua5.4,-llua5.4)
# OSMesa and EGL are loaded for the first picture.
RENDER_LIBS   := $(call flags,--libs,libpng freetype2,-lpng -lfreetype) -lisal -ldl

# ---- what there is ----
render_src := $(if $(filter 1,$(RENDER)),$(wildcard engine/render/*.c))
core_src   := $(filter-out engine/render/%,$(wildcard engine/*/*.c))
lua_src    := $(filter-out lua/main.c,$(wildcard lua/*.c))
lua_files  := $(wildcard lua/digbox/*.lua lua/digbox/*/*.lua)
unit_src   := $(wildcard tests/unit/test_*.c)
# The page of `digbox view` is built by node, which only those need who build it: `make viewer`.
viewer       := build/viewer/page.html
viewer_src   := engine/export/viewer
viewer_built := $(wildcard $(viewer))
# Only a test that includes a header of render/ (or of lua/) is linked with it.
unit_render := $(shell grep -lE '^\#include "render/' $(unit_src) /dev/null)
unit_lua    := $(shell grep -lE '^\#include ("lua/|<lua)' $(unit_src) /dev/null)
ifeq ($(RENDER),0)
unit_src   := $(filter-out $(unit_render),$(unit_src))
endif

objects  = $(patsubst %.c,$(OBJ)/%.o,$(1))
film_o  := $(OBJ)/lua/bind_film$(if $(filter 0,$(RENDER)),-norender).o
core_a   := $(BUILD)/libdigbox.a
render_a := $(if $(render_src),$(BUILD)/libdigbox_render.a)
lua_a    := $(BUILD)/libdigbox_lua.a
program  := $(BUILD)/digbox
unit_all := $(patsubst tests/unit/%.c,$(BUILD)/unit/%,$(unit_src))
unit     := $(if $(T),$(foreach p,$(unit_all),$(if $(findstring $(T),tests/unit/$(notdir $(p)).c),$(p))),$(unit_all))

ifeq ($(V),1)
say :=
Q   :=
else
say = @printf '  %-5s %s\n' $(1) $(2);
Q   := @
endif

.PHONY: all libs digbox.so viewer docs gallery demo test asan lint accuracy install deps clean help unit check-run
.PHONY: FORCE

all: $(program)                                 ## build/digbox, the program

libs: $(core_a) $(render_a)

$(program): $(call objects,lua/main.c) $(lua_a) $(render_a) $(core_a)
	$(call say,LINK,$@)$(LINK) $(static_asan) -o $@ $^ -Wl,--as-needed $(LUA_LIBS) $(EDIT_LIBS) $(if $(render_a),$(RENDER_LIBS)) $(CORE_LIBS)

digbox.so: $(BUILD)/digbox.so                   ## build/digbox.so, the module for a plain lua5.4
$(BUILD)/digbox.so: $(lua_a) $(render_a) $(core_a)
	$(call say,LINK,$@)$(LINK) -shared -o $@ -Wl,-u,luaopen_digbox $^ -Wl,--as-needed $(if $(render_a),$(RENDER_LIBS)) $(CORE_LIBS)

$(core_a):   $(call objects,$(core_src))
$(render_a): $(call objects,$(render_src))
$(lua_a):    $(call objects,$(filter-out lua/bind_film.c,$(lua_src))) $(film_o) $(BUILD)/embedded.o
$(core_a) $(render_a) $(lua_a): $(BUILD)/sources.txt
	$(call say,AR,$@)rm -f $@ && ar rcsD $@ $(filter %.o,$^)

$(OBJ)/lua/%.o $(BUILD)/embedded.o: extra = $(LUA_CFLAGS) -Ilua
$(OBJ)/lua/repl.o $(OBJ)/lua/doctor.o: extra += $(EDIT_CFLAGS)
$(OBJ)/lua/bind_film-norender.o: extra += -DDIGBOX_NO_RENDER
$(OBJ)/engine/render/%.o:               extra = $(RENDER_CFLAGS)
# Loops over pixels, which the compiler turns into wide instructions, to the same bits.
pixel_loops := $(if $(filter 1,$(DEBUG) $(SANITIZE)),,-O3 -fno-trapping-math)
$(patsubst %,$(OBJ)/engine/render/%.o,blur cast light png shade smooth): extra = $(RENDER_CFLAGS) $(pixel_loops)
# Blocks of 6 x 6: the same.
block_loops := $(if $(filter 1,$(DEBUG) $(SANITIZE)),,-O3 -fno-trapping-math)
$(patsubst %,$(OBJ)/engine/solve/%.o,blocks direct_rows direct_joints): extra = $(block_loops)

define compile
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) $(BASE) $(extra) -MMD -MP -c -o $@ $<
endef
$(OBJ)/%.o: %.c $(OBJ)/flags.txt
	$(compile)
$(film_o): lua/bind_film.c $(OBJ)/flags.txt
	$(compile)
$(BUILD)/embedded.o: $(BUILD)/embedded.c $(OBJ)/flags.txt
	$(compile)

# The Lua half of the program travels inside it, and so does the page of `digbox view` where it was built.
$(BUILD)/embedded.c: lua/embed.sh $(lua_files) $(viewer_built) $(BUILD)/sources.txt
	$(call say,EMBED,$@)sh lua/embed.sh $(lua_files) $(viewer_built) > $@.new && mv $@.new $@

# Changed flags rebuild everything, an added or removed source its library.
$(OBJ)/flags.txt: FORCE
	@mkdir -p $(@D); echo '$(CC) $(BASE) $(LUA_CFLAGS) $(RENDER_CFLAGS) $(EDIT_CFLAGS)' | cmp -s - $@ || \
	    echo '$(CC) $(BASE) $(LUA_CFLAGS) $(RENDER_CFLAGS) $(EDIT_CFLAGS)' > $@
$(BUILD)/sources.txt: FORCE
	@mkdir -p $(@D); echo '$(core_src) $(render_src) $(lua_src) $(lua_files) $(viewer_built)' | cmp -s - $@ || \
	    echo '$(core_src) $(render_src) $(lua_src) $(lua_files) $(viewer_built)' > $@

# ---- tests: one program per file; what is stale is gone before it is built ----
with_lua    = $(if $(filter $<,$(unit_lua)),$(lua_a))
with_render = $(if $(render_a),$(if $(filter $<,$(unit_render) $(unit_lua)),$(render_a)))
define build_test
	@mkdir -p $(@D)
	$(call say,CC,$<)rm -f $@ && $(CC) $(BASE) $(static_asan) $(LUA_CFLAGS) -Itests -I. -Ilua -MMD -MP -MF $@.d $< -o $@ $(with_lua) $(with_render) \
	    $(core_a) -Wl,--as-needed $(if $(with_lua),$(LUA_LIBS)) $(if $(with_render),$(RENDER_LIBS)) $(1) $(CORE_LIBS)
endef
$(BUILD)/unit/%: tests/unit/%.c $(core_a) $(render_a) $(lua_a)
	$(call build_test,-lcmocka)

unit: $(unit)

test:                                           ## everything that must hold; T=pattern takes the tests with it in their path
	@sh .ci/install.sh build test
	@$(MAKE) all || { echo "0 passed, 1 failed"; exit 1; }
	@$(MAKE) -k unit || true
	@BUILD=$(BUILD) SANITIZE=$(SANITIZE) RENDER=$(RENDER) CC=$(CC) bash tests/run.sh $(unit_src)

asan:                                           ## the tests again, under AddressSanitizer and UBSan
	@$(MAKE) test SANITIZE=1

lint:                                           ## what the compiler cannot see: floors, sizes, names, globals, Lua
	@sh .ci/install.sh build test
	@$(MAKE) libs || { echo "0 passed, 1 failed"; exit 1; }
	@BUILD=$(BUILD) CC=$(CC) T=tests/lint/ bash tests/run.sh

# ---- the page of `digbox view`: three.js and our own scripts in one file; npm is asked only when its lists change ----
$(viewer): $(viewer_src)/build.mjs $(wildcard $(viewer_src)/src/*) LICENSE build/viewer/installed
	$(call say,PAGE,$@)node $(viewer_src)/build.mjs build/viewer/node_modules LICENSE $@
build/viewer/installed: $(viewer_src)/package.json $(viewer_src)/package-lock.json
	$(call say,NPM,$(viewer_src))mkdir -p $(@D) && cp $^ $(@D) && \
	    cd $(@D) && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error && touch installed

viewer:                                         ## the page of `digbox view`, built with node and npm, into the program
	@sh .ci/install.sh build view
	@$(MAKE) $(viewer)
	@$(MAKE) all

# ---- what accuracy costs ----
-include tests/accuracy/accuracy.mk
-include tests/bench/bench.mk
-include tests/hard/hard.mk

# ---- random inputs ----
-include tests/fuzz/fuzz.mk

# ---- long films ----
-include tests/film/film.mk

# ---- what other programs make of exported replays ----
-include tests/export/export.mk

# ---- what effects cost ----
-include tests/cost/cost.mk

# ---- the first command of a newcomer ----
demo_world := ball_table_bucket
demo:                                           ## a film of worlds/ball_table_bucket.lua in out/
	@sh .ci/install.sh build
	@$(MAKE) all
	@mkdir -p out && rm -f out/$(demo_world)*
	@$(program) run worlds/$(demo_world).lua -o out
	@sh .ci/film.sh out/$(demo_world)

docs: all                                       ## writes what the program says of itself: docs/lua.md, materials.md, gallery.md
	@$(program) api --markdown > docs/lua.md.new && mv docs/lua.md.new docs/lua.md
	@$(program) api --materials > docs/materials.md.new && mv docs/materials.md.new docs/materials.md
	@sh .ci/gallery.sh page $(program) > docs/gallery.md.new && mv docs/gallery.md.new docs/gallery.md

gallery: all                                    ## a picture of every world in out/gallery/
	@sh .ci/gallery.sh pictures $(program)
	@$(MAKE) docs

install: all                                    ## program, libraries and header below PREFIX (default /usr/local)
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(PREFIX)/lib $(DESTDIR)$(PREFIX)/include $(DESTDIR)$(PREFIX)/share/doc/digbox/worlds
	install -m 755 $(program) $(DESTDIR)$(PREFIX)/bin/digbox
	install -m 644 $(core_a) $(render_a) $(DESTDIR)$(PREFIX)/lib
	install -m 644 engine/digbox.h $(DESTDIR)$(PREFIX)/include
	install -m 644 LICENSE README.md $(DESTDIR)$(PREFIX)/share/doc/digbox
	$(if $(wildcard worlds/*.lua),install -m 644 $(wildcard worlds/*.lua) $(DESTDIR)$(PREFIX)/share/doc/digbox/worlds)
	install -d $(DESTDIR)$(PREFIX)/share/man/man1 $(DESTDIR)$(PREFIX)/share/bash-completion/completions
	$(program) api --man > $(DESTDIR)$(PREFIX)/share/man/man1/digbox.1
	$(program) api --completion bash > $(DESTDIR)$(PREFIX)/share/bash-completion/completions/digbox
	install -m 644 docs/lua.md $(DESTDIR)$(PREFIX)/share/doc/digbox

deps:                                           ## installs the Debian packages that are missing (.ci/packages.txt)
	@sh .ci/install.sh build test

clean:                                          ## removes build/ and out/
	rm -rf build out

help:                                           ## this list
	@sed -n 's/^\([a-z-]*\):.*## /\1	/p' Makefile tests/*/*.mk | awk -F '\t' '{ printf "  make %-8s %s\n", $$1, $$2 }'
	@echo "  options: SANITIZE=1 DEBUG=1 RENDER=0 CC=clang V=1 T=pattern -jN"

-include $(wildcard $(OBJ)/*/*.d $(OBJ)/*/*/*.d $(BUILD)/unit/*.d)
