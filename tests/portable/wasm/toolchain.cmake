# WebAssembly by Debian's emscripten, with the libraries that tests/portable/wasm/libraries made in the folder WASM_LIBRARIES of the environment.
# No vectors (-msimd128): a vector of copies of one number, which clang 14 loads anew (v128.load64_splat), may be loaded after a later store to that number.
# In `axes[2] = rotation * axes[2]` the rest of the product was of the new component, and `plan` missed. Vectors gained 0 to 5 % of a calibration's time.
# As for GCC, a 64-bit number in braces for a 32-bit size is no error. include/ completes a standard library that is older than the code (libc++ 13).
include(/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
if(DEFINED ENV{WASM_LIBRARIES}) # a toolchain file is read again for each check of the compiler
  set(WASM_LIBRARIES $ENV{WASM_LIBRARIES} CACHE PATH "folder of libraries")
endif()
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES WASM_LIBRARIES)
set(CMAKE_CXX_FLAGS_INIT "-fwasm-exceptions -Wno-c++11-narrowing -isystem ${CMAKE_CURRENT_LIST_DIR}/include -isystem ${WASM_LIBRARIES}/include")
set(CMAKE_FIND_ROOT_PATH ${WASM_LIBRARIES})
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE BOTH)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_PREFIX_PATH ${WASM_LIBRARIES})
set(Eigen3_DIR /usr/share/eigen3/cmake CACHE PATH "headers alone")
set(ENV{PKG_CONFIG_DIR} "")
set(ENV{PKG_CONFIG_LIBDIR} ${WASM_LIBRARIES}/lib/pkgconfig)
set(ENV{PKG_CONFIG_PATH} "")
# A program is an ES module that makes an instance when it is called (web/module/run.js): files of node and of browsers, memory up to all of 32 bits.
set(WASM_WEB ${CMAKE_CURRENT_LIST_DIR}/../../../web)
string(JOIN " " CMAKE_EXE_LINKER_FLAGS_INIT
       "-sMODULARIZE=1 -sEXPORT_ES6=1 -sEXPORT_NAME=createEngine -sENVIRONMENT=web,worker,node -sDYNAMIC_EXECUTION=0 -sWASM_BIGINT=1"
       "-sFORCE_FILESYSTEM=1 -lnodefs.js -lworkerfs.js -sEXPORTED_RUNTIME_METHODS=FS,NODEFS,WORKERFS,ENV,callMain -sINVOKE_RUN=0 -sEXIT_RUNTIME=1"
       "-sALLOW_MEMORY_GROWTH=1 -sINITIAL_MEMORY=64MB -sMAXIMUM_MEMORY=4GB -sTOTAL_STACK=8MB"
       "--extern-pre-js ${WASM_WEB}/engine_before.js --pre-js ${WASM_WEB}/engine_inside.js")
