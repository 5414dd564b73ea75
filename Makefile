# SPDX-License-Identifier: Apache-2.0
# Builds, tests and installs knurl. `make help` lists what it can do.
#
#   config=release|debug|sanitize|coverage|fuzz   what kind of build (default release)
#   CC=gcc|clang                                  compiler; C++ follows it unless CXX is given
#   O=build                                       build root; everything made lies in $(O)/<config>/
#   V=1                                           show whole commands

config ?= release
O ?= build
B := $(O)/$(config)
VERSION := $(shell sed -n 's/^.define KN_VERSION_STRING "\(.*\)"/\1/p' include/knurl/base.h)
SOVERSION := $(firstword $(subst ., ,$(VERSION)))

JOBS := $(shell nproc 2>/dev/null || echo 1)
ifeq ($(MAKELEVEL),0)
MAKEFLAGS += -j$(JOBS) # a -j on the command line wins
endif
MAKEFLAGS += --no-builtin-rules --no-print-directory
.SUFFIXES:
.DELETE_ON_ERROR:
.DEFAULT_GOAL := all

# ---- compilers and flags ----
ifeq ($(origin CC),default)
CC := $(if $(filter fuzz,$(config)),clang,gcc)
endif
ifeq ($(origin CXX),default)
CXX := $(if $(findstring clang,$(CC)),$(subst clang,clang++,$(CC)),$(subst gcc,g++,$(CC)))
endif
AR ?= ar

# Bit-identical results between compilers and optimisation levels: no contraction, no fast-math, no -march.
COMMON := -Wall -Wextra -Werror -ffp-contract=off -fvisibility=hidden -fPIC -pthread -g
WARN_C := -std=c17 -Wpedantic -Wshadow -Wconversion -Wmissing-prototypes
WARN_CXX := -std=c++17
CPP := -Iinclude -I. -D_POSIX_C_SOURCE=200809L
OPT_release := -O3 -DNDEBUG
# Without optimisation gcc's vector gathers are macros, whose signs are not ours.
OPT_debug := -O0 -Wno-sign-conversion
# Instrumented code makes gcc warn of what is not there (its manual says so); the other builds carry the warnings.
# Lines and names are enough for their reports: -g1.
SANITIZERS := -g1 -w -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
OPT_sanitize := -O1 $(SANITIZERS)
OPT_coverage := $(OPT_debug) --coverage
OPT_fuzz := -O1 $(SANITIZERS) -fsanitize=fuzzer-no-link
ifeq ($(origin OPT_$(config)),undefined)
$(error config=$(config): one of release debug sanitize coverage fuzz)
endif
OPT := $(OPT_$(config))
ALL_CFLAGS = $(WARN_C) $(COMMON) $(OPT) $(CPP) $(CFLAGS)
ALL_CXXFLAGS = $(WARN_CXX) $(COMMON) $(OPT) $(CPP) $(CXXFLAGS)
ALL_LDFLAGS = $(OPT) -pthread -Wl,--as-needed $(LDFLAGS) # else knurl loads, at each start, what its bridges might use
LIBS := -lm

# ---- optional libraries, all in one place: a header that tells whether it is there, flags, what to link ----
EXTERNALS := tinygltf embree png cairo occt lib3mf jansson muparser openmesh zlib sisl cmocka flint
HEADER_tinygltf := tiny_gltf.h
LIBS_tinygltf := -ltinygltf
HEADER_embree := embree3/rtcore.h
LIBS_embree := -lembree3
HEADER_png := png.h
LIBS_png := -lpng
HEADER_cairo := cairo/cairo.h
LIBS_cairo := -lcairo
HEADER_occt := opencascade/Standard_Version.hxx
CPP_occt := -isystem /usr/include/opencascade
LIBS_occt := -lTKXDESTEP -lTKXDEIGES -lTKIGES -lTKXCAF -lTKLCAF -lTKCAF -lTKVCAF -lTKCDF -lTKSTEP -lTKSTEP209 -lTKSTEPAttr -lTKSTEPBase -lTKXSBase \
  -lTKShHealing -lTKFillet -lTKPrim -lTKBool -lTKBO -lTKTopAlgo -lTKGeomAlgo -lTKBRep -lTKGeomBase -lTKG3d -lTKG2d -lTKMath -lTKernel
HEADER_lib3mf := lib3mf/Model/COM/NMR_DLLInterfaces.h
CPP_lib3mf := -isystem /usr/include/lib3mf
LIBS_lib3mf := -l3MF
HEADER_jansson := jansson.h
LIBS_jansson := -ljansson
HEADER_muparser := muParser.h
LIBS_muparser := -lmuparser
HEADER_openmesh := OpenMesh/Core/IO/MeshIO.hh
LIBS_openmesh := -lOpenMeshCore
HEADER_zlib := zlib.h
LIBS_zlib := -lz
HEADER_sisl := sisl.h
LIBS_sisl := -lsisl
HEADER_cmocka := cmocka.h
LIBS_cmocka := -lcmocka
HEADER_flint := arb.h
LIBS_flint := -lflint-arb -lflint -lmpfr -lgmp


hash := \#
FOUND := $(shell printf '%s\n' $(foreach e,$(EXTERNALS),'$(hash)if __has_include(<$(HEADER_$(e))>)' $(e) '$(hash)endif') \
  | $(CXX) -E -P -x c++ - 2>/dev/null)

# ---- what there is to build: every file that exists in its place ----
MODULES := kernel bezier spline solve fit construct trivar cells fold trim mesh field tile compose job slice implicit levelset subdiv io cad step iges write
LIB_SRC := $(foreach m,$(MODULES),$(wildcard $(m)/*.c))
BRIDGES := $(filter $(FOUND),$(notdir $(patsubst %/,%,$(wildcard bridges/*/))))
bridge_src = $(wildcard bridges/$(1)/*.cpp bridges/$(1)/*.c)
BRIDGE_SRC := $(foreach b,$(BRIDGES),$(call bridge_src,$(b)))
CLI_SRC := $(wildcard cli/*.c)
TEST_SRC := $(filter-out $(if $(filter flint,$(FOUND)),,tests/oracle/%),$(wildcard tests/*/t_*.c)) # the oracle needs FLINT
SUPPORT_SRC := $(filter-out $(TEST_SRC),$(wildcard tests/support/*.c))
BENCH_SRC := $(wildcard bench/*.c)
FUZZ_SRC := $(wildcard tests/fuzz/fuzz_*.c)
HELPER_SRC := $(filter-out $(TEST_SRC) $(SUPPORT_SRC) tests/fuzz/%,$(wildcard tests/*/*.c)) # shared by a folder's tests

objects = $(patsubst %,$(B)/obj/%.o,$(1))
LIB_OBJ := $(call objects,$(LIB_SRC)) $(B)/obj/gen/embedded.c.o
LIB := $(B)/libknurl.a
BRIDGE_LIBS := $(foreach b,$(BRIDGES),$(B)/libknurl_$(b).a)
BRIDGE_LINK := $(foreach b,$(BRIDGES),$(LIBS_$(b))) $(if $(BRIDGES),-lstdc++)
WITH := $(foreach b,$(BRIDGES),-DKN_WITH_$(shell echo $(b) | tr a-z A-Z)=1)
SHARED := $(if $(filter release debug,$(config)),$(B)/libknurl.so.$(VERSION))
KNURL := $(if $(CLI_SRC),$(B)/knurl)
CAD_SRC := $(if $(filter occt,$(BRIDGES)),$(wildcard bridges/occt/program/*.cpp)) # a program beside knurl, which runs it
KNURL_CAD := $(if $(CAD_SRC),$(B)/knurl-cad)
KNURL_3DM := $(if $(KNURL),$(B)/knurl-3dm.cjs) # what node runs for Rhino files
TESTS := $(if $(filter cmocka,$(FOUND)),$(patsubst %.c,$(B)/%,$(filter-out $(if $(KNURL),,tests/cli/%),$(TEST_SRC))))
BENCH_MAIN := $(if $(BENCH_SRC),$(shell grep -l '^int main' $(BENCH_SRC))) # the others are shared by all of them
BENCHES := $(patsubst %.c,$(B)/%,$(BENCH_MAIN))
FUZZERS := $(patsubst %.c,$(B)/%,$(FUZZ_SRC))
ALL_SRC := $(LIB_SRC) $(BRIDGE_SRC) $(CAD_SRC) $(CLI_SRC) $(TEST_SRC) $(SUPPORT_SRC) $(HELPER_SRC) $(BENCH_SRC) $(wildcard tests/fuzz/*.c)

.PHONY: all lib tests benches fuzzers bench
all: lib $(KNURL) $(KNURL_CAD) $(KNURL_3DM)
lib: $(LIB) $(SHARED)
tests: $(TESTS)
benches: $(BENCHES)
fuzzers: $(FUZZERS)

Q := $(if $(V),,@)
say = $(if $(V),,@printf '  %-5s %s\n' $(1) $(2))

# $(call noted,NAME,TEXT): a file of that text, line by line, rewritten only when it changes. Several makes may do so at
# a time.
noted = $(shell mkdir -p $(B); new=$(B)/$(1).$$$$; printf '%s\n' $(2) > $$new; cmp -s $$new $(B)/$(1) && rm $$new || \
  mv $$new $(B)/$(1))
# What changes when the flags do, so that no object survives from other flags.
$(call noted,flags,'$(CC) $(CXX) $(ALL_CFLAGS) $(ALL_CXXFLAGS) $(WITH)')

$(B)/obj/cli/%.o $(B)/obj/tests/%.o: CPP += $(WITH)
$(B)/obj/bridges/occt/%.o $(B)/obj/tests/bridges/%.o: CPP += $(CPP_occt)
$(B)/obj/bridges/lib3mf/%.o: CPP += $(CPP_lib3mf)
ifneq ($(config),debug)
$(B)/obj/%.cpp.o: OPT += -g1 # a quarter of the time goes into what debuggers know of OCCT's templates
endif
$(B)/obj/%_avx2.c.o: OPT += -mavx2
$(patsubst %,$(B)/obj/kernel/eval_%.c.o,sse2 vector wide): OPT += -fno-tree-vectorize # they are vectors already
$(B)/obj/%_avx512.c.o: OPT += -mavx512f -mavx512dq -mavx512vl
$(B)/obj/%.c.o: %.c $(B)/flags
	@mkdir -p $(@D)
	$(call say,CC,$<)
	$(Q)$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<
$(B)/obj/%.cpp.o: %.cpp $(B)/flags
	@mkdir -p $(@D)
	$(call say,CXX,$<)
	$(Q)$(CXX) $(ALL_CXXFLAGS) -MMD -MP -c -o $@ $<
$(B)/obj/gen/%.c.o: $(B)/gen/%.c $(B)/flags
	@mkdir -p $(@D)
	$(call say,CC,$<)
	$(Q)$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<
-include $(patsubst %,$(B)/obj/%.d,$(ALL_SRC)) $(B)/obj/gen/embedded.c.d

$(LIB): $(LIB_OBJ) $(B)/lib.list
	$(call say,AR,$@)
	$(Q)rm -f $@; $(AR) rcs $@ $(LIB_OBJ)
$(SHARED): $(LIB_OBJ) $(B)/lib.list
	$(call say,LINK,$@)
	$(Q)$(CC) -shared -Wl,-soname,libknurl.so.$(SOVERSION) -Wl,--no-undefined $(ALL_LDFLAGS) -o $@ $(LIB_OBJ) $(LIBS)
	$(Q)ln -sf $(@F) $(B)/libknurl.so.$(SOVERSION); ln -sf libknurl.so.$(SOVERSION) $(B)/libknurl.so
# Rewritten when a source comes or goes.
$(call noted,lib.list,$(LIB_SRC))

define bridge_rule
$(B)/libknurl_$(1).a: $$(call objects,$$(call bridge_src,$(1)))
	$$(call say,AR,$$@)
	$$(Q)rm -f $$@; $$(AR) rcs $$@ $$^
endef
$(foreach b,$(BRIDGES),$(eval $(call bridge_rule,$(b))))

$(B)/knurl: $(call objects,$(CLI_SRC)) $(BRIDGE_LIBS) $(LIB)
	$(call say,LINK,$@)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $^ $(BRIDGE_LINK) $(if $(filter jansson,$(FOUND)),-ljansson) $(LIBS)

$(B)/knurl-cad: $(call objects,$(CAD_SRC)) $(B)/libknurl_occt.a $(LIB)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(ALL_LDFLAGS) -o $@ $^ $(LIBS_occt) $(LIBS)

$(B)/knurl-3dm.cjs: bridges/rhino3dm/write.cjs
	$(Q)mkdir -p $(@D) && cp $< $@

# ---- built-in tiles: files of data/tiles become constant bytes in the library ----
EMBEDDED := $(sort $(shell find data/tiles -type f -name '*.g2' 2>/dev/null))
$(call noted,embed.list,$(EMBEDDED))
$(B)/gen/embedded.c: tools/embed.sh $(B)/embed.list $(EMBEDDED)
	@mkdir -p $(@D)
	$(call say,EMBED,$@)
	$(Q)tools/embed.sh data/tiles $(EMBEDDED) > $@

# Writes them anew from their models; tiles-check compares what is there with what would be written.
.PHONY: tiles tiles-check tiles-sheet
tiles:
	$(Q)python3 tools/tiles data/tiles io/builtin_table.h
tiles-sheet: $(KNURL) # a picture of each, and one of all
	$(Q)python3 tools/tiles/sheet.py $(KNURL) data/tiles $(B)/tiles-sheet docs/pictures
tiles-check:
	$(Q)rm -rf $(B)/tiles; python3 tools/tiles $(B)/tiles/data $(B)/tiles/table.h
	$(Q)diff -r data/tiles $(B)/tiles/data && diff io/builtin_table.h $(B)/tiles/table.h || \
	  { echo 'data/tiles and io/builtin_table.h differ from their models: run make tiles'; exit 1; }

# ---- gallery: the pictures of docs/gallery.md, each a recipe ----
GALLERY := chess wicker chain knit moebius vases flower fur fur-gravity fur-wind
.PHONY: gallery gallery-knob $(GALLERY:%=gallery-%)
gallery: $(if $(CAD_SRC),gallery-knob) $(GALLERY:%=gallery-%)
gallery-moebius: RECIPE := examples/moebius/moebius.json
gallery-moebius: VIEW := --azimuth 60 --elevation 30
gallery-fur-gravity gallery-fur-wind: RECIPE := examples/gallery/fur.json
gallery-fur-gravity: APPLY := --attraction 0,0,-2.2
gallery-fur-wind: APPLY := --attraction 2.4,0.8,-0.4
gallery-fur gallery-fur-gravity gallery-fur-wind: VIEW := --width 720 --height 540
gallery-flower: VIEW := --height 260 --samples 64 --azimuth -25 --elevation 24
$(GALLERY:%=gallery-%): gallery-%: $(KNURL)
	@mkdir -p $(O)/gallery
	$(Q)$(KNURL) apply $(or $(RECIPE),examples/gallery/$*.json) $(APPLY) -q -o $(O)/gallery/$*.glb
	$(Q)$(KNURL) render $(O)/gallery/$*.glb --width 960 --height 720 $(VIEW) -q -o $(O)/gallery/$*.png
	@echo '  $(O)/gallery/$*.png'

# docs/pictures/knob.png: what is in the STEP file.
KNOB := $(O)/gallery/knob
gallery-knob: $(KNURL) $(KNURL_CAD)
	@mkdir -p $(O)/gallery
	$(Q)$(KNURL) apply examples/cad/knob.json --color 0 --palette 565e68,565e68 -q -o $(KNOB).step
	$(Q)$(KNURL) convert $(KNOB).step -q -o $(KNOB).glb
	$(Q)$(KNURL) render $(KNOB).glb --width 800 --height 600 --samples 256 --elevation 17 --azimuth 15 -q -o $(KNOB).png
	@echo '  $(KNOB).png'

# ---- tests: each t_*.c is a program; it may use libknurl's internals, so it links the static library ----
SUPPORT := $(B)/libsupport.a
$(SUPPORT): $(call objects,$(SUPPORT_SRC))
	$(Q)rm -f $@; $(AR) rcs $@ $^
TEST_LIBS := -lcmocka $(if $(filter jansson,$(FOUND)),-ljansson)
define test_rule
$(B)/tests/$(1)/t_%: $(B)/obj/tests/$(1)/t_%.c.o $(call objects,$(filter tests/$(1)/%,$(HELPER_SRC))) $(SUPPORT) \
  $(if $(filter bridges cli,$(1)),$(BRIDGE_LIBS)) $(LIB)
	@mkdir -p $$(@D)
	$$(call say,LINK,$$@)
	$$(Q)$$(CC) $$(ALL_LDFLAGS) -o $$@ $$^ $(if $(filter bridges cli,$(1)),$(BRIDGE_LINK)) $(if $(filter oracle,$(1)),$(LIBS_flint)) \
	  $$(TEST_LIBS) $$(LIBS)
endef
$(foreach d,$(sort $(patsubst tests/%/,%,$(dir $(TEST_SRC)))),$(eval $(call test_rule,$(d))))


.PHONY: test test-built
test: tests $(KNURL) $(KNURL_CAD) $(KNURL_3DM)
	$(Q)$(MAKE) test-built
test-built: # runs what there is, also when some of it did not build: a missing program is a failure
	$(Q)KNURL=$(abspath $(KNURL)) tests/run.sh $(B)/test-logs $(JOBS) $(TESTS)

# ---- fuzzing: with config=fuzz through libFuzzer, else a driver of our own replays and mutates the seeds ----
FUZZ_SECONDS ?= 30
$(B)/tests/fuzz/fuzz_%: $(B)/obj/tests/fuzz/fuzz_%.c.o $(if $(filter fuzz,$(config)),,$(B)/obj/tests/fuzz/driver.c.o) $(LIB)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CC) $(subst fuzzer-no-link,fuzzer,$(ALL_LDFLAGS)) -o $@ $^ $(LIBS)
.PHONY: fuzz
ifeq ($(config),fuzz)
fuzz: fuzzers
	$(Q)for f in $(FUZZERS); do seeds=tests/fuzz/corpus/$${f##*/fuzz_}; new=$(B)/corpus/$${f##*/fuzz_}; \
	  mkdir -p $$new; $$f -max_total_time=$(FUZZ_SECONDS) -max_len=65536 -artifact_prefix=$(B)/ $$new \
	    $$(test -d $$seeds && echo $$seeds) || exit 1; done
else
fuzz:
	$(Q)$(MAKE) config=fuzz fuzz
endif

# ---- benchmarks ----
$(B)/obj/bench/%.o: CPP += $(if $(filter sisl,$(FOUND)),-DKN_WITH_SISL=1)
$(B)/bench/%: $(B)/obj/bench/%.c.o $(call objects,$(filter-out $(BENCH_MAIN),$(BENCH_SRC))) $(LIB)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $^ $(BENCH_LIBS) $(if $(filter sisl,$(FOUND)),-lsisl -lstdc++) $(LIBS)
ifneq ($(filter occt,$(BRIDGES)),) # other writers of the same faces
$(B)/obj/bench/exchange.c.o: CPP += -DKN_WITH_OCCT=1
$(B)/bench/exchange: $(B)/libknurl_occt.a
$(B)/bench/exchange: BENCH_LIBS = $(B)/libknurl_occt.a $(LIB) $(LIBS_occt) -lstdc++
endif
bench: benches
	$(Q)for b in $(BENCHES); do echo "== $${b##*/}"; $$b || exit 1; done

# ---- checks that compile nothing into the product ----
HEADERS := $(wildcard include/knurl/*.h)
C_FILES := $(sort $(shell find $(MODULES) bridges cli examples bench tests include -name '*.[ch]' 2>/dev/null))
CXX_FILES := $(sort $(shell find bridges tests examples -name '*.cpp' -o -name '*.hpp' 2>/dev/null))
.PHONY: layers symbols api headers format lint tidy cppcheck selftest
layers:
	$(Q)tools/layers.sh
symbols: lib
	$(Q)tools/symbols.sh $(LIB) $(SHARED)
api: lib
	$(Q)tools/api.sh $(SHARED)
selftest:
	$(Q)tools/selftest.sh
headers: $(HEADERS:include/knurl/%.h=$(B)/headers/%.ok)
$(B)/headers/%.ok: include/knurl/%.h $(HEADERS) $(B)/flags
	@mkdir -p $(@D)
	$(call say,ALONE,$<)
	$(Q)echo '#include <knurl/$*.h>' | $(CC) $(WARN_C) -Wall -Wextra -Werror -Iinclude -fsyntax-only -x c -
	$(Q)echo '#include <knurl/$*.h>' | $(CXX) $(WARN_CXX) -Wpedantic -Wshadow -Wconversion -Wall -Wextra -Werror -Iinclude \
	  -fsyntax-only -x c++ -
	@touch $@
format:
	$(Q)bad=$$(clang-format --dry-run -Werror $(C_FILES) $(CXX_FILES) 2>&1 | sed -n 's/^\([^ :]*\):.* error: .*/\1/p' | sort -u); \
	  test -z "$$bad" || { printf 'not formatted: %s\n' $$bad; exit 1; }

# clang-tidy file by file, again only when the file, a header or the configuration changed.
LINT_C := $(LIB_SRC) $(CLI_SRC) $(TEST_SRC) $(SUPPORT_SRC) $(HELPER_SRC) $(BENCH_SRC) $(wildcard tests/fuzz/*.c examples/*/*.c)
LINT_CXX := $(filter %.cpp,$(BRIDGE_SRC)) $(CAD_SRC)
PROJECT_HEADERS := $(filter %.h %.hpp,$(C_FILES) $(CXX_FILES))
lint: tidy cppcheck
tidy: $(patsubst %,$(B)/tidy/%.ok,$(LINT_C) $(LINT_CXX))
$(B)/tidy/cli/%.ok $(B)/tidy/tests/%.ok: CPP += $(WITH)
$(B)/tidy/bridges/occt/%.ok $(B)/tidy/tests/bridges/%.ok: CPP += $(CPP_occt)
$(B)/tidy/bridges/lib3mf/%.ok: CPP += $(CPP_lib3mf)
$(B)/tidy/%.c.ok: %.c $(PROJECT_HEADERS) .clang-tidy tests/.clang-tidy
	@mkdir -p $(@D)
	$(call say,TIDY,$<)
	$(Q)clang-tidy --quiet $< -- $(WARN_C) $(CPP) >$@.log 2>&1 || { cat $@.log; exit 1; }
	@touch $@
$(B)/tidy/%.cpp.ok: %.cpp $(PROJECT_HEADERS) .clang-tidy tests/.clang-tidy
	@mkdir -p $(@D)
	$(call say,TIDY,$<)
	$(Q)clang-tidy --quiet $< -- $(WARN_CXX) $(CPP) >$@.log 2>&1 || { cat $@.log; exit 1; }
	@touch $@
cppcheck:
	@mkdir -p $(B)/cppcheck
	$(call say,CHECK,'the core and the command')
	$(Q)cppcheck --quiet -j$(JOBS) --std=c11 --enable=warning,performance,portability --inline-suppr --error-exitcode=1 \
	  --suppressions-list=tools/cppcheck.txt --cppcheck-build-dir=$(B)/cppcheck -Iinclude -I. $(LIB_SRC) $(CLI_SRC)

# ---- coverage of the core by the tests, module by module ----
.PHONY: coverage
coverage:
ifeq ($(config),coverage)
	$(Q)find $(B) -name '*.gcda' -delete
	$(Q)$(MAKE) config=coverage test
	$(Q)tools/coverage.sh $(B) $(LIB_SRC)
else
	$(Q)$(MAKE) config=coverage coverage
endif

# ---- installation ----
PREFIX ?= /usr/local
DEST = $(DESTDIR)$(PREFIX)
FILL = sed -e 's|@PREFIX@|$(PREFIX)|g' -e 's|@VERSION@|$(VERSION)|g' -e 's|@SOVERSION@|$(SOVERSION)|g'
.PHONY: install uninstall
install: all
	$(Q)install -d $(DEST)/include/knurl $(DEST)/lib/pkgconfig $(DEST)/lib/cmake/knurl $(DEST)/share/knurl
	$(Q)install -m 644 $(HEADERS) $(DEST)/include/knurl/
	$(Q)install -m 644 $(LIB) $(DEST)/lib/
	$(Q)install -m 755 $(SHARED) $(DEST)/lib/
	$(Q)ln -sf libknurl.so.$(VERSION) $(DEST)/lib/libknurl.so.$(SOVERSION)
	$(Q)ln -sf libknurl.so.$(SOVERSION) $(DEST)/lib/libknurl.so
	$(Q)$(FILL) packaging/knurl.pc.in > $(DEST)/lib/pkgconfig/knurl.pc
	$(Q)$(FILL) packaging/knurlConfig.cmake.in > $(DEST)/lib/cmake/knurl/knurlConfig.cmake
	$(Q)$(FILL) packaging/knurlConfigVersion.cmake.in > $(DEST)/lib/cmake/knurl/knurlConfigVersion.cmake
	$(Q)install -m 644 data/teapot.bpt $(DEST)/share/knurl/
ifneq ($(KNURL),)
	$(Q)install -d $(DEST)/bin $(DEST)/libexec/knurl
	$(Q)install -m 755 $(KNURL) $(DEST)/bin/
	$(Q)install -m 644 $(KNURL_3DM) $(DEST)/libexec/knurl/
endif
ifneq ($(KNURL_CAD),)
	$(Q)install -d $(DEST)/libexec/knurl
	$(Q)install -m 755 $(KNURL_CAD) $(DEST)/libexec/knurl/
endif
ifneq ($(wildcard docs/knurl.1),)
	$(Q)install -d $(DEST)/share/man/man1
	$(Q)install -m 644 docs/knurl.1 $(DEST)/share/man/man1/
endif
uninstall:
	$(Q)rm -rf $(DEST)/include/knurl $(DEST)/lib/cmake/knurl $(DEST)/share/knurl $(DEST)/libexec/knurl
	$(Q)rm -f $(DEST)/lib/libknurl.a $(DEST)/lib/libknurl.so $(DEST)/lib/libknurl.so.$(SOVERSION) \
	  $(DEST)/lib/libknurl.so.$(VERSION) $(DEST)/lib/pkgconfig/knurl.pc $(DEST)/bin/knurl $(DEST)/share/man/man1/knurl.1

# ---- the two commands of the README, and the rest ----
.PHONY: setup check demo clean help
setup:
	$(Q)tools/setup.sh
check: setup
	+$(Q)tools/check.sh $(O) $(JOBS)
demo: setup
	+$(Q)$(MAKE) config=release all
	$(Q)examples/teapot/demo.sh $(O)/release/knurl $(O)/demo
clean:
	rm -rf $(O)
help:
	@sed -n 's/^#   /    /p' $(firstword $(MAKEFILE_LIST))
	@echo
	@printf '    %-10s %s\n' all 'the library and the command, $(O)/release/knurl (default)' \
	  check 'everything that is tested; ends in "N passed, N failed, N skipped"' \
	  demo 'the textured teapots' \
  gallery 'the pictures of docs/gallery.md; gallery-chess and so on: one of them' \
	  test 'the test programs of this configuration' \
	  bench 'every benchmark' \
	  fuzz 'libFuzzer on every target for FUZZ_SECONDS each' \
	  coverage 'line coverage of the core by the tests' \
	  lint 'clang-tidy and cppcheck' \
	  format 'is every file formatted?' \
	  layers 'do includes point downwards only?' \
	  symbols 'kn_ names only, nothing writable, nothing printed' \
	  api 'is every declared function exported and tested?' \
	  headers 'does every public header compile alone?' \
	  install 'to $$(DESTDIR)$$(PREFIX), uninstall to undo' \
	  setup 'install the Debian packages that are missing' \
	  clean 'remove $(O)'

.SECONDARY:
