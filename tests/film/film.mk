# tests/film/film.mk - `make film-soak`: long films, F7 and F13 of docs/security.md; FRAMES=100000 RESUMED=10000.
.PHONY: film-soak
FRAMES  ?= 100000
RESUMED ?= 10000

film-soak: all                                  ## a film of 100,000 frames: memory, files, time a frame; 10,000 resumed over damage
	@DIGBOX=$(abspath $(program)) bash tests/film/soak.sh $(FRAMES) $(RESUMED)
