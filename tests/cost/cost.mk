# tests/cost/cost.mk - the program without some effects, and the proof that what no scene calls for costs nothing.
#
#   make without WITHOUT=friction           build/without-friction/digbox: that effect is not in the list of engine/effect/effects.c
#   make without EFFECTS="gravity contact"  the same with these alone
#   make cost-proof                         instructions of 600 frames of a stack: all effects compiled in against the mechanical ones
#
# Only the list and the program are built again; all else is that of the full build.

.PHONY: without cost-proof
effect_names := $(sort $(patsubst &effect_%,%,$(shell grep -o '&effect_[a-z_0-9]*' engine/effect/effects.c)))
mechanical   := gravity push contact friction rolling joints
WITHOUT      ?= $(if $(EFFECTS),$(filter-out $(EFFECTS),$(effect_names)))
nothing      :=
without_dir  := $(BUILD)/without$(subst $(nothing) $(nothing),,$(addprefix -,$(sort $(WITHOUT))))
without_own  := $(call objects,engine/effect/effects.c)

without:                                        ## the program without some effects: WITHOUT="a b", or EFFECTS="those alone"
	@$(if $(strip $(WITHOUT)),,echo "without: which? WITHOUT=... or EFFECTS=... of: $(effect_names)" >&2; exit 2;) \
	$(if $(filter-out $(effect_names),$(WITHOUT) $(EFFECTS)),echo "without: unknown: $(filter-out $(effect_names),$(WITHOUT) $(EFFECTS)); known: \
	    $(effect_names)" >&2; exit 2;) $(MAKE) $(without_dir)/digbox WITHOUT='$(WITHOUT)'

ifneq ($(strip $(WITHOUT)),)
$(without_dir)/effects.c: engine/effect/effects.c
	@mkdir -p $(@D)
	@sed $(foreach name,$(WITHOUT),-e 's/&effect_$(name),//') $< > $@

$(without_dir)/effects.o: $(without_dir)/effects.c $(OBJ)/flags.txt
	$(call say,CC,$@)$(CC) $(BASE) -c -o $@ $<

$(without_dir)/digbox: $(call objects,lua/main.c) $(lua_a) $(render_a) $(without_dir)/effects.o $(filter-out $(without_own),$(call objects,$(core_src)))
	$(call say,LINK,$@)$(LINK) -o $@ $^ -Wl,--as-needed $(LUA_LIBS) $(EDIT_LIBS) $(if $(render_a),$(RENDER_LIBS)) $(CORE_LIBS)
endif

cost-proof:                                     ## instructions of a stack, all effects compiled in against the mechanical ones (valgrind)
	@sh .ci/install.sh build proof
	@$(MAKE) all
	@$(if $(filter-out $(mechanical),$(effect_names)),$(MAKE) without EFFECTS='$(mechanical)')
	@DIGBOX='$(program)' FEWER='$(BUILD)/without$(subst $(nothing) $(nothing),,$(addprefix -,$(filter-out $(mechanical),$(effect_names))))/digbox' \
	    bash tests/cost/proof/instructions.sh
