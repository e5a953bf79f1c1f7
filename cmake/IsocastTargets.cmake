# How a folder becomes a target.
# SPDX-License-Identifier: MPL-2.0

add_library(isocast_options INTERFACE)
target_compile_options(isocast_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow
                                                 -Wnon-virtual-dtor -Werror)
# Options are written with designated initialisers that leave defaults out.
target_compile_options(isocast_options INTERFACE -Wno-missing-field-initializers)
# No contraction to fused multiply-add: results must not depend on where the compiler finds one.
target_compile_options(isocast_options INTERFACE -ffp-contract=off)
if(ISOCAST_SANITIZE)
    set(sanitize -fsanitize=${ISOCAST_SANITIZE} -fno-omit-frame-pointer
                 -fno-sanitize-recover=all)
    target_compile_options(isocast_options INTERFACE ${sanitize})
    target_link_options(isocast_options INTERFACE ${sanitize})
endif()
if(ISOCAST_SANITIZE OR CMAKE_BUILD_TYPE STREQUAL "Debug")
    target_compile_definitions(isocast_options INTERFACE ISOCAST_CHECKED=1)
endif()

# isocast_folder(volume SOURCES a.cpp … PUBLIC lib … PRIVATE lib …)
# makes the library isocast::volume. Its headers are reached through a directory that holds this
# folder alone, so that including a folder that is not linked does not compile: no back edges.
function(isocast_folder folder)
    cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
    set(root ${CMAKE_BINARY_DIR}/include/${folder})
    file(MAKE_DIRECTORY ${root})
    file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${root}/${folder} SYMBOLIC)
    add_library(isocast_${folder} STATIC ${arg_SOURCES})
    add_library(isocast::${folder} ALIAS isocast_${folder})
    target_include_directories(isocast_${folder} PUBLIC ${root})
    target_link_libraries(isocast_${folder} PUBLIC ${arg_PUBLIC} PRIVATE isocast_options
                                                                         ${arg_PRIVATE})
    if("fmt::fmt" IN_LIST arg_PRIVATE)
        # What these cost is half of a file's time, and is paid once a folder.
        target_precompile_headers(isocast_${folder} PRIVATE <Eigen/Geometry> <fmt/format.h>
                                                            <filesystem> <functional> <map>)
        # gcc 12 takes Eigen's empty vectors for uninitialised, and strings for short ones, where it
        # knows headers from such files.
        target_compile_options(
            isocast_${folder}
            PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized;-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>)
    endif()
endfunction()
