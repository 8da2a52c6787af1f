# The library under sanitizers. The tests are compiled once, without: they are linked with the library as it is, and with the library under sanitizers.
function(imulab_sanitize)
  foreach(target ${ARGN})
    # -O1: with -Og it compiles in three quarters of the time, and runs about twice as long. Assertions are on: Eigen's too. The four checks of every
    # access are a third of the compiler's time; the fuzz targets have them, and memory beyond an object or at null is the address sanitizer's too.
    target_compile_options(${target} PRIVATE -O1 -g1 -UNDEBUG "SHELL:-U _FORTIFY_SOURCE" -fsanitize=address,undefined -fno-sanitize=null,alignment,vptr,object-size
                           -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
    target_compile_definitions(${target} PRIVATE EIGEN_MALLOC_ALREADY_ALIGNED=1) # as in the tests' own code: Eigen would put a header before its blocks
    target_link_options(${target} PRIVATE -fsanitize=address,undefined)
  endforeach()
  imulab_keep_compilers_form(${ARGN})
endfunction()

# The compiler's own form of each unit besides the code, for the test OneDefinition; nothing is linked from it.
function(imulab_keep_compilers_form)
  if(IMULAB_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    foreach(target ${ARGN})
      target_compile_options(${target} PRIVATE -flto -ffat-lto-objects)
    endforeach()
    imulab_link_code(${ARGN})
  endif()
endfunction()

# Links the code of such units and leaves the compiler's form alone, from which the linker would make all of it again.
function(imulab_link_code)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    foreach(target ${ARGN})
      target_link_options(${target} PRIVATE -fno-lto)
    endforeach()
  endif()
endfunction()
