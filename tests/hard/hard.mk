# tests/hard/hard.mk - the hard cases: `make hard-cases` and `make soak`.
#
#   make hard-cases                          all of them at all frame steps; writes docs/stability.md
#   make hard-cases CASE=B06 STEP=1/60       some of them: their table is build/hard/report.md, the document stays as it is
#   make hard-cases FILM=1                   with a picture of the end of each run in build/hard/pictures/
#   make hard-cases LIMIT=20                 CPU seconds that one run may take (60)
#   make soak [SEED=1] [COUNT=1000] [SOAK_SECONDS=20]   random worlds; a seed that fails is shrunk and printed as a script;
#                                            then the properties of DIGs and messages on 1000 worlds each

.PHONY: hard-cases soak
SEED    ?= 1
COUNT   ?= 1000
SOAK_SECONDS ?= 20

hard-cases: all                                 ## the hard cases at every frame step; writes docs/stability.md
	@BUILD=$(BUILD) LIMIT=$(LIMIT) FILM=$(FILM) sh tests/hard/measure.sh "$(CASE)" "$(STEP)"
	@lua5.4 tests/hard/report.lua $(BUILD)/hard/rows $(if $(CASE),$(BUILD)/hard/report.md,docs/stability.md)

soak: all                                       ## 1000 random worlds for 20 s each
	@BUILD=$(BUILD) sh tests/hard/soak.sh $(SEED) $(COUNT) $(SOAK_SECONDS)
	@$(MAKE) unit T=test_properties && DIGBOX_FULL=1 $(BUILD)/unit/test_properties
