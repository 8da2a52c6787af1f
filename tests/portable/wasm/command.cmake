# The command as a module is loaded at every visit: what does not compute is compiled for size.
set_target_properties(imulab_command PROPERTIES LINK_DEPENDS "${WASM_WEB}/engine_before.js;${WASM_WEB}/engine_inside.js")
foreach(part imulab_files imulab_app imulab_verbs imulab_command)
  target_compile_options(${part} PRIVATE -Oz -finline-functions) # with emscripten's -Oz alone only the linker inlines
  set_target_properties(${part} PROPERTIES DISABLE_PRECOMPILE_HEADERS ON) # they are compiled with other options
endforeach()
