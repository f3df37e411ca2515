//! Polyhedral meshes: topology, geometry, blockMesh, checks, renumbering, partitioning.
