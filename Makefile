# lightkiln. `make help` lists the goals; `make V=1` shows the commands.

VERSION  := 0.1.0
SONAME   := liblightkiln.so.0
PREFIX   ?= /usr/local
DESTDIR  ?=
B        ?= build
TIMEOUT  ?= 600 # seconds a test program may take
JOBS     ?= $(shell nproc 2>/dev/null || echo 2)
Q        := $(if $(V),,@)
say       = $(if $(V),,@printf '  %-8s%s\n' '$(1)' '$(2)')
parallel  = $(if $(findstring -j,$(MAKEFLAGS)),,-j$(JOBS))
COMMIT   := $(shell git describe --always --dirty --exclude '*' 2>/dev/null || echo unknown)

PACKAGES := OpenImageIO OpenCL tinygltf
OPTIMISE ?= -O2
WARN     ?= -Wall -Wextra -Werror -Wno-format-truncation # snprintf is used to cut
COMMON   := $(OPTIMISE) $(WARN) -fopenmp -fvisibility=hidden -fPIC $(SANITIZE) \
            -D_GNU_SOURCE -Iinclude -Isrc -I$(B)/gen $(shell pkg-config --cflags $(PACKAGES) 2>/dev/null)
ALL_CFLAGS   := -std=c11 $(COMMON) $(CFLAGS)
ALL_CXXFLAGS := -std=c++17 $(COMMON) $(CXXFLAGS)
LINK         := -fopenmp $(SANITIZE) $(LDFLAGS) -Wl,--as-needed
LIBS         := $(shell pkg-config --libs $(PACKAGES) 2>/dev/null) -lm

# The library is everything but main.c and cli/; the command links it and reaches it through lightkiln.h.
CLI_SRC  := src/main.c $(wildcard src/cli/*.c)
LIB_SRC  := $(filter-out $(CLI_SRC),$(wildcard src/*.c src/*/*.c src/*/*.cpp))
# Long ones first, so that none is left alone at the end.
TEST_SRC := $(wildcard tests/ref/test_*.c) $(wildcard tests/engine/test_*.c)
TEST_SRC += $(filter-out $(TEST_SRC),$(wildcard tests/*/test_*.c))
HELP_SRC := $(wildcard tests/*.c)
object    = $(patsubst %,$(B)/%.o,$(basename $(1)))
LIB_OBJ  := $(call object,$(LIB_SRC)) $(B)/gen/cl_sources.o
CLI_OBJ  := $(call object,$(filter-out src/main.c,$(CLI_SRC)))
TESTS    := $(TEST_SRC:%.c=$(B)/%)
STATIC   := $(B)/cli.a $(B)/liblightkiln.a
CL       := $(wildcard cl/*.cl)
TEST_CL  := $(wildcard tests/device/*.cl)
HELP_OBJ := $(call object,$(HELP_SRC)) $(B)/gen/test_cl_sources.o
HEADERS  := $(wildcard include/*/*.h src/*.h src/*/*.h src/*/*.hpp tests/*.h tests/*/*.h)
FORMATTED := $(wildcard bench/*.c src/*.c src/*/*.c src/*/*.cpp tests/*.c tests/*/*.c cl/*.cl cl/*/*.h) $(TEST_CL) $(HEADERS)

.PHONY: all demo bench bench-peers test test-device run-tests lint asan format install portable clean help setup FORCE
.DELETE_ON_ERROR:
.SECONDARY:

all: $(B)/lightkiln $(B)/$(SONAME) ## Builds build/lightkiln, liblightkiln.a and liblightkiln.so (the default)

demo: setup ## Sets up, builds, and renders the Cornell box to build/demo/
	$(Q)$(MAKE) --no-print-directory $(parallel) all
	$(Q)mkdir -p $(B)/demo
	$(B)/lightkiln render scenes/cornell.gltf -o $(B)/demo/cornell.exr --width 256
	$(B)/lightkiln render scenes/cornell.gltf -o $(B)/demo/cornell.png --width 256

# FULL=1 takes what the experiments take; BENCH='--device gpu --time 60' hands options on.
BENCH_SCENES := $(addprefix $(B)/scenes/,cornell.glb cathedral.glb atrium.glb deck.glb)
bench: ## Runs the thesis's experiments on scenes of our own into build/bench: report, tables, plots
	$(Q)scripts/setup
	$(Q)scripts/setup --bench
	$(Q)$(MAKE) --no-print-directory $(parallel) all $(BENCH_SCENES)
	$(B)/lightkiln bench report $(BENCH_SCENES) $(if $(FULL),,--quick) --out $(B)/bench $(BENCH)
	$(Q)scripts/plot $(B)/bench
	@echo 'Read $(B)/bench/report.md'
$(B)/scenes/%.glb: scripts/make_scenes $(wildcard scripts/scenes/*.py)
	$(call say,SCENE,$@)
	$(Q)scripts/make_scenes --out $(@D) $*

test: setup ## Sets up, builds, and runs every test
	$(Q)$(MAKE) --no-print-directory $(parallel) run-tests

test-device: setup ## As test, but only tests/device
	$(Q)$(MAKE) --no-print-directory $(parallel) run-tests ONLY=device

asan: setup ## As test, with the address and undefined-behaviour sanitizers, in build/asan
	$(Q)$(MAKE) --no-print-directory $(parallel) run-tests B=build/asan OPTIMISE='-O1 -g' \
	    SANITIZE='-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer'

setup:
	$(Q)scripts/setup

# ONLY=folder runs tests/folder alone, ONLY=folder/test_name one program.
run-tests: all $(TESTS)
	$(Q)LIGHTKILN=$(B)/lightkiln TIMEOUT=$(TIMEOUT) scripts/run_tests $(filter $(B)/tests/$(ONLY)%,$(TESTS))

# SCENES="a.glb b.glb" traces those; BENCH='--width 512' hands options on.
SCENES ?= scenes/cornell.gltf
bench-peers: setup ## Traces the same rays with Embree 3 (Debian: libembree-dev) and prints the ratios
	$(Q)echo '#include <embree3/rtcore.h>' | $(CC) -E -x c - > /dev/null 2>&1 || \
	    { echo 'bench-peers: install Embree 3 (Debian: apt-get install libembree-dev)' >&2; exit 1; }
	$(Q)$(MAKE) --no-print-directory $(parallel) $(B)/bench/peers
	$(Q)for scene in $(SCENES); do $(B)/bench/peers embree "$$scene" $(BENCH) || exit 1; done

# ---- compile and link

# Holds the flags, so that changing them builds anew; the same for what is generated on every run.
define keep # file, text
	$(Q)mkdir -p $(dir $(1))
	$(Q)printf '%s\n' '$(2)' | cmp -s - $(1) || printf '%s\n' '$(2)' > $(1)
endef
$(B)/flags: FORCE
	$(call keep,$@,$(CC) $(ALL_CFLAGS) / $(CXX) $(ALL_CXXFLAGS) / $(LINK) $(LIBS))
$(B)/gen/version.h: FORCE
	$(call keep,$@,#define LIGHTKILN_VERSION "$(VERSION) ($(COMMIT))")

$(B)/%.o: %.c $(B)/flags
	$(call say,CC,$<)
	$(Q)mkdir -p $(@D)
	$(Q)$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<
$(B)/%.o: %.cpp $(B)/flags
	$(call say,CXX,$<)
	$(Q)mkdir -p $(@D)
	$(Q)$(CXX) $(ALL_CXXFLAGS) -MMD -MP -c -o $@ $<
$(B)/gen/%.o: $(B)/gen/%.c $(B)/flags
	$(call say,CC,$<)
	$(Q)$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<

$(B)/src/api.o: $(B)/gen/version.h
$(B)/gen/cl_sources.c: scripts/embed_cl $(CL) $(wildcard cl/lib/*.h include/shared/*.h)
	$(call say,EMBED,cl/*.cl)
	$(Q)mkdir -p $(@D)
	$(Q)scripts/embed_cl $(CL) > $@
$(B)/gen/test_cl_sources.c: scripts/embed_cl $(TEST_CL) $(CL) $(wildcard tests/device/*.h cl/lib/*.h include/shared/*.h)
	$(call say,EMBED,tests/device/*.cl)
	$(Q)mkdir -p $(@D)
	$(Q)EMBED_PREFIX=test_ scripts/embed_cl $(TEST_CL) > $@

# Archives and links depend on the flags, too, so that a source that is gone leaves no object behind.
$(B)/liblightkiln.a: $(LIB_OBJ) $(B)/flags
$(B)/cli.a: $(CLI_OBJ) $(B)/flags
%.a:
	$(call say,AR,$@)
	$(Q)rm -f $@
	$(Q)$(AR) qcs $@ $(filter %.o,$^)
$(B)/$(SONAME): $(LIB_OBJ) src/exports.map
	$(call say,LINK,$@)
	$(Q)$(CXX) -shared $(LINK) -Wl,-soname,$(SONAME) -Wl,--version-script=src/exports.map \
	    $(if $(SANITIZE),,-Wl,-z,defs) -o $@ $(LIB_OBJ) $(LIBS)
$(B)/lightkiln: $(B)/src/main.o $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LINK) -o $@ $^ $(LIBS)
$(B)/bench/peers: $(B)/bench/peers.o $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LINK) -o $@ $^ -lembree3 $(LIBS)
$(B)/tests/%: $(B)/tests/%.o $(HELP_OBJ) $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LINK) -o $@ $^ -lcmocka $(LIBS)
$(call object,$(TEST_SRC) $(HELP_SRC)): ALL_CFLAGS += -Itests

-include $(patsubst %.o,%.d,$(LIB_OBJ) $(CLI_OBJ) $(B)/src/main.o $(B)/bench/peers.o $(HELP_OBJ) $(call object,$(TEST_SRC)))

# ---- keep

lint: setup $(B)/gen/version.h ## Checks kernels, headers, include rules and format
	$(Q)C='$(CC) $(ALL_CFLAGS)' CPP='$(CXX) $(ALL_CXXFLAGS)' scripts/lint $(CL) $(TEST_CL) $(wildcard cl/lib/*.h) $(HEADERS)
	$(call say,LAYERS,src)
	$(Q)scripts/check_layers
	$(call say,FORMAT,)
	$(Q)clang-format --dry-run -Werror $(FORMATTED)

format: ## Formats every C, C++ and OpenCL C file
	$(Q)clang-format -i $(FORMATTED)

install: all $(B)/lightkiln.pc ## Installs under PREFIX (/usr/local), within DESTDIR
	install -d $(addprefix $(DESTDIR)$(PREFIX)/,bin lib/pkgconfig include/lightkiln share/man/man1)
	install $(B)/lightkiln $(DESTDIR)$(PREFIX)/bin/
	install -m 644 $(B)/liblightkiln.a $(DESTDIR)$(PREFIX)/lib/
	install $(B)/$(SONAME) $(DESTDIR)$(PREFIX)/lib/
	ln -sf $(SONAME) $(DESTDIR)$(PREFIX)/lib/liblightkiln.so
	install -m 644 include/lightkiln/*.h $(DESTDIR)$(PREFIX)/include/lightkiln/
	install -m 644 $(B)/lightkiln.pc $(DESTDIR)$(PREFIX)/lib/pkgconfig/
	install -m 644 docs/lightkiln.1 $(DESTDIR)$(PREFIX)/share/man/man1/
$(B)/lightkiln.pc: lightkiln.pc.in FORCE
	$(Q)sed 's|@PREFIX@|$(PREFIX)|; s|@VERSION@|$(VERSION)|; s|@LIBS@|$(LIBS) -fopenmp|' $< > $@

portable: setup ## Makes build/lightkiln-portable.tar.xz for machines with only a driver; SPLIT=N cuts it (MiB)
	$(Q)$(MAKE) --no-print-directory $(parallel) all
	$(Q)scripts/portable $(if $(SPLIT),--split $(SPLIT)) $(B)

clean: ## Removes build/
	rm -rf build

help: ## Prints this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  \1\t\2/p' Makefile | expand -t 16
