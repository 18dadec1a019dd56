# Gives the targets longspan::longspan (shared) and longspan::static.
get_filename_component(_longspan_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
include(CMakeFindDependencyMacro)
find_dependency(Threads)

if(NOT TARGET longspan::longspan)
    add_library(longspan::longspan SHARED IMPORTED)
    set_target_properties(longspan::longspan PROPERTIES
        IMPORTED_LOCATION "${_longspan_prefix}/lib/liblongspan.so"
        INTERFACE_INCLUDE_DIRECTORIES "${_longspan_prefix}/include")
    add_library(longspan::static STATIC IMPORTED)
    set_target_properties(longspan::static PROPERTIES
        IMPORTED_LOCATION "${_longspan_prefix}/lib/liblongspan.a"
        INTERFACE_INCLUDE_DIRECTORIES "${_longspan_prefix}/include"
        INTERFACE_LINK_LIBRARIES "Threads::Threads;${CMAKE_DL_LIBS};m")
endif()
unset(_longspan_prefix)
