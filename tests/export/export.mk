# tests/export/export.mk - make export-check: the .glb of some worlds before Khronos' gltf-validator and Blender.
.PHONY: export-check
export-check:                                   ## exported worlds in gltf-validator and Blender
	@sh .ci/install.sh build export
	@$(MAKE) all
	@BUILD=$(BUILD) bash tests/export/check.sh
