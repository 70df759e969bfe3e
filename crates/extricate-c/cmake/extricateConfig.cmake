# extricate::extricate is the shared library, extricate::static the one that is linked in. extricate.hpp is beside
# extricate.h, and needs C++17.
get_filename_component(_extricate_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET extricate::extricate)
    add_library(extricate::extricate SHARED IMPORTED)
    set_target_properties(extricate::extricate PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${_extricate_prefix}/include"
        IMPORTED_LOCATION "${_extricate_prefix}/lib/@SHARED@")
endif()

if(NOT TARGET extricate::static AND EXISTS "${_extricate_prefix}/lib/libextricate_c.a")
    find_package(Threads REQUIRED)
    add_library(extricate::static STATIC IMPORTED)
    set_target_properties(extricate::static PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${_extricate_prefix}/include"
        IMPORTED_LOCATION "${_extricate_prefix}/lib/libextricate_c.a"
        INTERFACE_LINK_LIBRARIES "Threads::Threads;${CMAKE_DL_LIBS};m")
endif()

unset(_extricate_prefix)
set(extricate_FOUND TRUE)
