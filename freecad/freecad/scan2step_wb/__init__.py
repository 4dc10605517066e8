"""scan2step in FreeCAD: scans become faces, shells and solids."""
