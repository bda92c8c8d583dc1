"""Tables as CSV or Excel sheets: FRFs and blows imported, modes and receptances read and written."""
